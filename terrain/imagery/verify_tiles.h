// Checks the tiles of a scene: the directory, and that every tile decodes to what it should show. Uses threads of its
// own while it runs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "proto/imagery/tile.h"
#include "terrain/store/scene.h"

namespace foreland::terrain {

struct LayerReport {
  proto::TileContent content{};
  uint64_t tiles = 0;  // stored, all of which were decoded
  // Relief: angles between the normals of its finest level and those of the samples, both by central differences, where
  // there are neighbours on all sides.
  double rms_rad = 0, largest_rad = 0;
};

struct TilesReport {
  std::vector<LayerReport> layers;
  uint64_t faults = 0;
  std::vector<std::string> first_faults;  // a sentence each, the same ones for any number of threads
};

// Imagery: every tile is a picture of a tile's size, and bounds hold those of finer tiles.
// Relief: heights of the finest level are within half a step of the samples', gutters included; each level is the mean
// of the one below; bounds hold the samples' heights and normals, and those of finer tiles.
[[nodiscard]] TilesReport verifyTiles(const Scene& scene, unsigned threads = 0);
// Error if the file cannot be opened as a scene.
[[nodiscard]] Result<TilesReport> verifyTiles(const std::filesystem::path& path, unsigned threads = 0);

}  // namespace foreland::terrain
