// The texels of a tile of relief, in steps of its level, from the heights of the level's texels.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "proto/imagery/relief_codec.h"
#include "proto/imagery/tile.h"

namespace foreland::terrain {

// Writes all texels of a tile, its gutter included, which beyond the layer repeats the border. heightAt(x, y) is the
// height of a texel of the tile's level, in quanta of `height_quantum_m`.
template <class HeightAt>
void takeReliefSteps(const proto::TileLayer& layer, const proto::TileId& tile, double height_quantum_m,
                     const HeightAt& heightAt, std::vector<int32_t>& steps) {
  const double scale = height_quantum_m / layer.stepAt(tile.level);
  const auto clamped = [](uint32_t tile_at, uint32_t i, uint32_t count) {
    const int64_t at = int64_t{tile_at} * proto::kTilePayload + i - proto::kTileGutter;
    return static_cast<uint32_t>(std::clamp<int64_t>(at, 0, int64_t{count} - 1));
  };
  const uint32_t width = layer.widthAt(tile.level), height = layer.heightAt(tile.level);
  steps.resize(proto::kTileTexels);
  auto out = steps.begin();
  for (uint32_t j = 0; j < proto::kTileSide; ++j)
    for (uint32_t i = 0, y = clamped(tile.y, j, height); i < proto::kTileSide; ++i)
      *out++ =
          static_cast<int32_t>(std::nearbyint(static_cast<double>(heightAt(clamped(tile.x, i, width), y)) * scale));
}

}  // namespace foreland::terrain
