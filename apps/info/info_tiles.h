// What foreland-info says of a scene's relief and imagery.
#pragma once

#include <nlohmann/json.hpp>

#include "terrain/store/scene.h"

namespace foreland::apps {

nlohmann::ordered_json describeTiles(const terrain::TileTable& tiles);
void printTiles(const terrain::Scene& scene);

}  // namespace foreland::apps
