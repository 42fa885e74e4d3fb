// MARTINI on the heights of a scene: transcribed to C++ (plain_martini.h), and as its makers wrote it, run by node (npm
// @mapbox/martini). It extracts right-triangulated meshes of one error in metres for the whole of a square of 2^k + 1
// samples: it knows no view and culls nothing, and its error parameter is no bound, for it compares each midpoint with
// its own edge and not with the surface. Blocks.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/store/scene.h"

namespace foreland::lab {

// One mesh to measure: the one whose triangle count comes nearest to `triangles`, or, if that is 0, the one of
// `max_error_m`.
struct MartiniRequest {
  double triangles = 0;
  double max_error_m = 0;
};

struct MartiniMesh {
  double max_error_m = 0;   // its parameter
  double true_error_m = 0;  // largest difference in height between mesh and samples
  double triangles = 0;
  double ms = 0;  // median
  double mtri_per_s = 0;
};

struct MartiniResult {
  std::string version, node;        // of the package and of node; empty in C++
  uint32_t grid_size = 0;           // samples a side
  double tables_ms = 0;             // once per grid size
  double tile_ms = 0;               // once per terrain: its errors
  double clear_ms = 0;              // part of each mesh's time: it clears an index of all samples
  std::vector<MartiniMesh> meshes;  // as requested
};

// The largest square of 2^k + 1 samples that the data has, at most 4097 (MARTINI keeps 28 bytes a sample).
uint32_t martiniGridSize(const proto::GridShape& shape);

// In C++, on the thread that calls.
MartiniResult runPlainMartini(const terrain::Scene& scene, const std::vector<MartiniRequest>& requests);

// In JavaScript; writes a temporary file. `folder` holds martini.mjs and node_modules. kNotFound, with the way out, if
// node or the package is missing.
Result<MartiniResult> runMartini(const terrain::Scene& scene, const std::filesystem::path& folder,
                                 const std::vector<MartiniRequest>& requests);

}  // namespace foreland::lab
