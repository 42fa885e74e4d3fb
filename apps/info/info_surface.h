// Describes a surface file, for `foreland info`. Main thread.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "terrain/surface_store/mapped_surface.h"

namespace foreland::apps {

nlohmann::ordered_json describeSurface(const terrain::MappedSurface& surface);
// How many solids are inside of whatever is drawn of it, and how far off that may be, in the object's units.
std::string solidsText(const terrain::MappedSurface& surface);
void printSurface(const std::string& path, const terrain::MappedSurface& surface);

}  // namespace foreland::apps
