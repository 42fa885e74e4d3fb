#include "client/ground/ground_heights.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "base/check.h"

namespace foreland::client {

using proto::kTileGutter;
using proto::kTilePayload;
using proto::kTileSide;

namespace {

bool isKnown(const GroundCell& cell) {
  return std::all_of(std::begin(cell.heights_m), std::end(cell.heights_m), [](double h) { return std::isfinite(h); });
}

std::optional<GroundCell> cellOf(const GroundPatch& patch, glm::dvec2 at) {
  const uint32_t rows = patch.rows();
  if (patch.columns < 2 || rows < 2) return std::nullopt;
  const glm::dvec2 p = (at - patch.low) / patch.spacing;
  if (!(p.x >= 0 && p.y >= 0 && p.x <= patch.columns - 1.0 && p.y <= rows - 1.0)) return std::nullopt;
  const uint32_t x = std::min(static_cast<uint32_t>(p.x), patch.columns - 2);
  const uint32_t y = std::min(static_cast<uint32_t>(p.y), rows - 2);
  const float* h = &patch.heights_m[size_t{y} * patch.columns + x];
  GroundCell cell{.low = patch.low + glm::dvec2(x, y) * patch.spacing,
                  .side = patch.spacing,
                  .heights_m = {h[0], h[1], h[patch.columns], h[patch.columns + 1]}};
  return isKnown(cell) ? std::optional(cell) : std::nullopt;
}

}  // namespace

void GroundHeights::enter(std::optional<proto::TileLayer> relief) {
  relief_ = std::move(relief);
  tiles_.clear();
  exact_ = {}, mesh_ = {};
}

void GroundHeights::add(const proto::TileId& tile, std::vector<int32_t> steps) {
  CHECK_EQ(steps.size(), size_t{kTileSide} * kTileSide);
  tiles_[tile.key()] = std::move(steps);
}

void GroundHeights::keep(std::span<const uint64_t> keys) {
  std::erase_if(tiles_,
                [&](const auto& entry) { return std::find(keys.begin(), keys.end(), entry.first) == keys.end(); });
}

// Texels lie at the middles of their squares, so cells begin half a texel further on.
std::optional<GroundCell> GroundHeights::reliefCell(glm::dvec2 at) const {
  if (!relief_ || tiles_.empty()) return std::nullopt;
  const proto::TileLayer& layer = *relief_;
  // Half a texel beyond the last ones their heights hold, too; there is no ground further out.
  const glm::dvec2 inside = (at - layer.origin) / layer.texel;
  if (!(inside.x >= 0 && inside.y >= 0 && inside.x <= layer.width && inside.y <= layer.height)) return std::nullopt;
  for (uint32_t level = 0; level < layer.levels(); ++level) {
    const double texel = layer.texelAt(level);
    const glm::dvec2 p = (at - layer.origin) / texel - 0.5;
    const auto column = static_cast<int64_t>(std::floor(p.x)), row = static_cast<int64_t>(std::floor(p.y));
    const auto tileOf = [](int64_t i, uint32_t tiles) {
      return static_cast<uint32_t>(std::clamp<int64_t>(i / kTilePayload, 0, int64_t{tiles} - 1));
    };
    const proto::TileId tile{0, static_cast<uint8_t>(level), tileOf(column, layer.tilesX(level)),
                             tileOf(row, layer.tilesY(level))};
    const auto found = std::find_if(tiles_.begin(), tiles_.end(), [&](const auto& entry) {
      const proto::TileId id = proto::TileId::of(entry.first);
      return id.level == tile.level && id.x == tile.x && id.y == tile.y;
    });
    if (found == tiles_.end()) continue;
    const auto x = static_cast<size_t>(column - int64_t{tile.x} * kTilePayload + kTileGutter);
    const auto y = static_cast<size_t>(row - int64_t{tile.y} * kTilePayload + kTileGutter);
    if (x + 1 >= kTileSide || y + 1 >= kTileSide) continue;
    const double step_m = layer.stepAt(level);
    const int32_t* h = &found->second[y * kTileSide + x];
    return GroundCell{.low = layer.origin + (glm::dvec2(column, row) + 0.5) * texel,
                      .side = texel,
                      .heights_m = {h[0] * step_m, h[1] * step_m, h[kTileSide] * step_m, h[kTileSide + 1] * step_m},
                      .coarse_m = 0.5 * step_m};
  }
  return std::nullopt;
}

std::optional<GroundCell> GroundHeights::cellAt(glm::dvec2 at) const {
  std::optional<GroundCell> best;
  for (const auto& cell : {cellOf(exact_, at), reliefCell(at), cellOf(mesh_, at)})
    if (cell && (!best || cell->side < best->side)) best = cell;
  return best;
}

std::optional<double> GroundHeights::heightAt(glm::dvec2 at) const {
  const auto cell = cellAt(at);
  if (!cell) return std::nullopt;
  const glm::dvec2 t = (at - cell->low) / cell->side;
  const double* h = cell->heights_m;
  return (h[0] + t.x * (h[1] - h[0])) * (1 - t.y) + (h[2] + t.x * (h[3] - h[2])) * t.y;
}

std::optional<glm::dvec2> GroundHeights::gradientAt(glm::dvec2 at) const {
  const auto cell = cellAt(at);
  if (!cell) return std::nullopt;
  const glm::dvec2 t = (at - cell->low) / cell->side;
  const double* h = cell->heights_m;
  return glm::dvec2((h[1] - h[0]) * (1 - t.y) + (h[3] - h[2]) * t.y, (h[2] - h[0]) * (1 - t.x) + (h[3] - h[1]) * t.x) /
         cell->side;
}

double slopeOf(const proto::FrameTransform& frame, const proto::LatticePosition& at, glm::dvec2 gradient) {
  const glm::dvec3 here = frame.toScene(at);
  const glm::dvec3 x = frame.toScene(proto::LatticePosition{at.x + 1, at.y, at.height_m + gradient.x}) - here;
  const glm::dvec3 y = frame.toScene(proto::LatticePosition{at.x, at.y + 1, at.height_m + gradient.y}) - here;
  return std::acos(std::clamp(glm::dot(glm::normalize(glm::cross(x, y)), frame.upAt(here)), -1.0, 1.0));
}

}  // namespace foreland::client
