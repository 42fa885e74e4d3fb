#include "client/imagery/slopes.h"

#include <algorithm>
#include <glm/packing.hpp>
#include <glm/vec2.hpp>
#include <vector>

#include "base/check.h"

namespace foreland::client {

namespace {

constexpr uint32_t kTexels = proto::kTileSide;

// The texels of a row, or a column, between which the slope at a texel is taken, and what to multiply their difference
// by.
struct Difference {
  uint32_t low, high;
  float scale;
};

// Texels beyond the raster repeat its border, so they tell nothing.
std::vector<Difference> differencesOf(uint32_t tile, uint32_t texels, double rise_per_step) {
  const int64_t first = int64_t{tile} * proto::kTilePayload - proto::kTileGutter;
  const int64_t low_end = std::max<int64_t>(-first, 0);
  const int64_t high_end = std::min<int64_t>(int64_t{texels} - 1 - first, kTexels - 1);
  std::vector<Difference> out(kTexels);
  for (int64_t i = 0; i < kTexels; ++i) {
    const int64_t at = std::clamp(i, low_end, std::max(low_end, high_end));
    const int64_t low = std::max(at - 1, low_end), high = std::min(at + 1, high_end);
    Difference& d = out[static_cast<size_t>(i)];
    if (high <= low) {  // a single texel
      d = {static_cast<uint32_t>(i), static_cast<uint32_t>(i), 0};
      continue;
    }
    d = {static_cast<uint32_t>(low), static_cast<uint32_t>(high),
         static_cast<float>(rise_per_step / static_cast<double>(high - low))};
  }
  return out;
}

}  // namespace

void slopesOf(const proto::TileLayer& layer, const proto::TileId& tile, std::span<const int32_t> steps,
              std::span<uint32_t> out) {
  CHECK_EQ(steps.size(), proto::kTileTexels);
  CHECK_EQ(out.size(), steps.size());
  const double step_m = layer.stepAt(tile.level);
  const double per_step = step_m / layer.texelAt(tile.level);
  // A globe's raster has no border.
  const auto differences = [&](uint32_t at, uint32_t texels) {
    return layer.isGlobe() ? differencesOf(1, proto::kMaxLayerSide, per_step) : differencesOf(at, texels, per_step);
  };
  const auto columns = differences(tile.x, layer.widthAt(tile.level));
  const auto rows = differences(tile.y, layer.heightAt(tile.level));
  for (uint32_t y = 0; y < kTexels; ++y) {
    const Difference& row = rows[y];
    const int32_t* here = &steps[size_t{y} * kTexels];
    const int32_t* south = &steps[size_t{row.low} * kTexels];
    const int32_t* north = &steps[size_t{row.high} * kTexels];
    for (uint32_t x = 0; x < kTexels; ++x) {
      const Difference& column = columns[x];
      const glm::vec2 slope(static_cast<float>(here[column.high] - here[column.low]) * column.scale,
                            static_cast<float>(north[x] - south[x]) * row.scale);
      out[size_t{y} * kTexels + x] = glm::packHalf2x16(slope);
    }
  }
}

void halfImageOf(const proto::TileId& tile, std::span<const uint32_t> parent, std::span<uint32_t> out) {
  CHECK_EQ(parent.size(), proto::kTileTexels);
  CHECK_EQ(out.size(), size_t{kHalfSide} * kHalfSide);
  const uint32_t *from = &parent[size_t{halfImageAt(tile.y)} * kTexels + halfImageAt(tile.x)], *row = from;
  for (uint32_t y = 0; y < kHalfSide; ++y, row += kTexels) std::copy_n(row, kHalfSide, &out[size_t{y} * kHalfSide]);
}

void halfSlopesOf(std::span<const uint32_t> own, std::span<uint32_t> out) {
  CHECK_EQ(own.size(), proto::kTileTexels);
  CHECK_EQ(out.size(), size_t{kHalfSide} * kHalfSide);
  for (uint32_t y = 0; y < kHalfSide; ++y)
    for (uint32_t x = 0; x < kHalfSide; ++x) {
      const uint32_t* at = &own[size_t{2} * y * kTexels + 2 * x];
      out[size_t{y} * kHalfSide + x] =
          glm::packHalf2x16(0.25f * (glm::unpackHalf2x16(at[0]) + glm::unpackHalf2x16(at[1]) +
                                     glm::unpackHalf2x16(at[kTexels]) + glm::unpackHalf2x16(at[kTexels + 1])));
    }
}

}  // namespace foreland::client
