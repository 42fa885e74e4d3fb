// How far a scene's heights are from a file that it was made of, at the file's own samples. One thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "proto/section/epochs.h"
#include "terrain/dem/raster/open_options.h"
#include "terrain/dem/warp/sample_places.h"

namespace foreland::terrain {

// The heights of a scene on its lattice, metres.
struct LatticeHeights {
  LatticePlace lattice;
  std::function<double(uint32_t x, uint32_t y)> at;
};

// Where a raster of the file alone counts in the scene, as the scene states it.
struct SourceExtent {
  std::vector<proto::LatticeWindow> above{};  // of what lies over it, lattice samples
  double feather_m = 0;
};

struct SourceDifference {
  std::string name;       // of the raster, without its folder
  double largest_m = 0;   // of what is drawn at full resolution and of bilinear heights from the samples
  uint64_t compared = 0;  // samples
  uint64_t left_out = 0;  // that have data, but others count there, too, or may; or that lie beyond the scene
};

// Of every raster of a file; `extentOf` is asked by its name. An Error: the file cannot be read or placed.
Result<std::vector<SourceDifference>> compareSource(
    const std::filesystem::path& file, const OpenOptions& options, const LatticeHeights& scene,
    const std::function<Result<SourceExtent>(const std::string& name)>& extentOf);

}  // namespace foreland::terrain
