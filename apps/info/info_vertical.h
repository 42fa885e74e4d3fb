// What heights of a scene count from, and what it was put together from, for people and for programs.
#pragma once

#include <nlohmann/json.hpp>

#include "terrain/store/scene.h"

namespace foreland::apps {

void printVertical(const terrain::Scene& scene);
nlohmann::ordered_json describeVertical(const terrain::Scene& scene);

}  // namespace foreland::apps
