// Describes the objects of a scene, for `foreland info`. Main thread.
#pragma once

#include <nlohmann/json.hpp>

#include "terrain/objects/placed_objects.h"

namespace foreland::apps {

// The `count` of all objects, and `models`: for each the keys of describeSurface, and how often it is `placed`.
nlohmann::ordered_json describeObjects(const terrain::PlacedObjects& objects);
// Prints nothing if there are no objects.
void printObjects(const terrain::PlacedObjects& objects);

}  // namespace foreland::apps
