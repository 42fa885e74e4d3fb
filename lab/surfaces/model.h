// A model or surface file as a surface to measure: a model is read, remeshed, its positions in whole quanta.
#pragma once

#include <filesystem>

#include "base/result.h"
#include "terrain/surface/surface.h"

namespace foreland::lab {

// `path` is an OBJ or PLY file, or a surface file of `foreland remesh`, which is taken as it is. A model is remeshed to
// about `base_triangles` and `halvings` levels of quadrisection. Errors are the reader's and the remesher's. Cost:
// seconds for a model.
Result<terrain::TrueSurface> surfaceOfModel(const std::filesystem::path& path, uint32_t base_triangles,
                                            uint32_t halvings);

}  // namespace foreland::lab
