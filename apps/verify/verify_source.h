// Whether a scene is as close to the files that it was made of as it states.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/options/foreign_files.h"
#include "base/result.h"

namespace foreland::apps {

// Prints how far the scene is off each raster of the files, and returns how many are further off than is stated. A file
// may be followed by @vertical=..., as for `foreland build`. An Error: a file that cannot be read, or that the scene
// does not name as an input.
Result<uint64_t> verifySources(const std::string& scene, const std::vector<std::string>& sources,
                               const ForeignFiles& foreign);

}  // namespace foreland::apps
