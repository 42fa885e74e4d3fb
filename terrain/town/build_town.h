// A synthetic town as a scene: the models of its houses go through the remesher, and stand on the ground as the objects
// of the scene. For measurements and tests of objects in large numbers. One caller; uses threads of its own.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/pipeline/build.h"

namespace foreland::terrain {

struct TownOptions {
  std::filesystem::path output;  // the scene file; its models are made beside it, and removed
  uint32_t buildings = 2000;     // at most proto::ObjectSet::kMaxObjects
  uint64_t seed = 1;
  uint32_t base_triangles = 200;
  int levels = 4;
  unsigned threads = 0;  // 0: one per processor
};

struct TownModelReport {
  std::string name;
  uint64_t placed = 0;
  size_t solids = 0;
  double volume_share = 0;     // that inner solids hold
  double largest_error_m = 0;  // of what is drawn at any level
};

struct TownReport {
  BuildReport scene;
  std::vector<TownModelReport> models;
  double radius_m = 0;  // of the town
};

// The same options give the same bytes. Errors: no buildings, or more than a scene holds; the disk's.
[[nodiscard]] Result<TownReport> buildTown(const TownOptions& options, const Progress& progress = {});

}  // namespace foreland::terrain
