// Elevation data in, one scene file out: read in windows, fill voids, quantise, bound, write. The file appears whole or
// not at all (terrain/store/scene_writer.h). Memory: four bytes a sample, and what the source and the filling of voids
// need. One caller; uses threads of its own while it runs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "terrain/elevation_source.h"
#include "terrain/objects/placed_objects.h"
#include "terrain/store/scene.h"

namespace foreland::terrain {

struct BuildOptions {
  std::filesystem::path output;
  double height_quantum_m = 0.1;  // heights are kept in whole steps: each is moved by at most half of one
  unsigned threads = 0;           // 0: one per processor
  // Of 1, 1/2 and 1/4 m the first that is larger than height_quantum_m and that every height of the source is a
  // multiple of, if there is one, instead: no sample is moved, and a scene costs fewer bits to send. Filled voids are
  // rounded.
  bool widen_step = false;
  std::vector<ObjectRequest> objects{};  // that stand on the terrain
};

// Called on the caller's thread. `report` gets the stage's name and the fraction of it that is done, at least at 0 and
// 1 of each; once `keepGoing` says false the build stops, leaves nothing behind and returns an error.
struct Progress {
  std::function<void(std::string_view stage, double fraction)> report = [](std::string_view, double) {};
  std::function<bool()> keepGoing = [] { return true; };
};

struct BuildReport {
  uint32_t width = 0, height = 0;
  uint64_t samples = 0;
  uint64_t voids_filled = 0;
  std::vector<std::string> notes;  // the source's, how voids were filled, and whether the step was widened
  double height_quantum_m = 0;     // that was taken
  int levels = 0;
  uint64_t nodes = 0;  // refinement vertices; padding not counted
  uint64_t file_bytes = 0;
  uint64_t scene_id = 0;
  double lowest_m = 0, highest_m = 0;
};

[[nodiscard]] Result<BuildReport> buildScene(ElevationSource& source, const BuildOptions& options,
                                             const Progress& progress = {});

}  // namespace foreland::terrain
