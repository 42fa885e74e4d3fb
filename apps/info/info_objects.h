// What objects stand in a scene, for `foreland info`. Main thread.
#pragma once

#include <nlohmann/json.hpp>

#include "terrain/objects/placed_objects.h"

namespace foreland::apps {

// `count` of all, and of each model what describeSurface says and how many of them are `placed`.
nlohmann::ordered_json describeObjects(const terrain::PlacedObjects& objects);
// Nothing without objects.
void printObjects(const terrain::PlacedObjects& objects);

}  // namespace foreland::apps
