// A scene of a whole body (proto/topology/cube.h): everywhere as fine as the base of a GlobeSource, and finer where its
// insets are. One caller; uses threads of its own while it runs. Time and memory as of sparse_build.h.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/globe_picture.h"
#include "terrain/globe_source.h"
#include "terrain/imagery/imagery.h"
#include "terrain/objects/placed_objects.h"
#include "terrain/pipeline/build.h"

namespace foreland::terrain {

struct GlobeOptions {
  std::filesystem::path output;
  double height_quantum_m = 0.1;  // heights become whole quanta: each moves by at most half of one
  unsigned threads = 0;           // 0: one per processor
  // How far the ground may be above or below insets' samples, metres, before heights are rounded; by default it is as
  // fine everywhere as the inset that lies there.
  std::optional<double> residual_m{};
  PageCoding page_coding = PageCoding::kPlain;
  std::vector<ObjectRequest> objects{};  // that stand on it, at latitudes and longitudes
  const GlobePicture* picture = nullptr;
  int imagery_quality = kDefaultImageryQuality;
  std::string attribution{};  // of the picture
  bool has_sea = false;       // viewers draw it
};

// How fine a globe is: faces of 2^whole_log2 steps a side everywhere, of 2^deepest_log2 where the finest inset is, the
// fewest with which vertices lie no further apart than samples do; with a residual, than a quarter of what samples of
// insets do, or as fine as globes can be.
struct GlobeDepth {
  uint32_t whole_log2 = 1, deepest_log2 = 1;
};
Result<GlobeDepth> depthOf(const GlobeInfo& info, std::optional<double> residual_m = {});

// `samples` and sizes of the report are those of the lattice. The scene states for each input by how much the ground
// that is drawn at full resolution is above or below its samples at most, where it alone counts.
[[nodiscard]] Result<BuildReport> buildGlobe(const GlobeSource& source, const GlobeOptions& options,
                                             const Progress& progress = {});

}  // namespace foreland::terrain
