// A model or surface file as a surface to measure: a model is read, remeshed, its positions in whole steps.
#pragma once

#include <filesystem>

#include "base/result.h"
#include "terrain/surface/surface.h"

namespace foreland::bench {

// OBJ, PLY, or what `foreland remesh` made of one, which is taken as it is. `base_triangles` are asked for, `halvings`
// are quadrisection's; both are for models. Errors are the reader's and the remesher's. Cost: seconds for a model.
Result<terrain::TrueSurface> surfaceOfModel(const std::filesystem::path& path, uint32_t base_triangles,
                                            uint32_t halvings);

}  // namespace foreland::bench
