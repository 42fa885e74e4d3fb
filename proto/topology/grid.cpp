#include "proto/topology/grid.h"

#include <string>

namespace foreland::proto {

namespace {

// Cells of 2^(t+1) samples along one axis of `roots` roots, with the one past the end that owns the far border's sides
// if there are any.
uint64_t cellsAlong(uint32_t roots, int level, bool has_far_sides) {
  return (static_cast<uint64_t>(roots) << (level / 2)) + (has_far_sides ? 1 : 0);
}

}  // namespace

Result<GridTopology> GridTopology::create(const GridShape& shape) {
  const auto refuse = [](const std::string& what) { return Error{ErrorCode::kMalformed, "grid shape: " + what}; };
  const uint32_t max_log2 = shape.is_cube ? kMaxCubeLog2 : kMaxRootLog2;
  if (shape.root_log2 < 1 || shape.root_log2 > max_log2)
    return refuse("root squares of 2^" + std::to_string(shape.root_log2) + " samples; 2^1 to 2^" +
                  std::to_string(max_log2) + " are supported");
  if (shape.is_cube && shape != cubeShape(shape.root_log2, shape.sparse_levels))
    return refuse("a cube has 6 x 1 roots that are full of data");
  if (!shape.is_cube && (shape.roots_x < 1 || shape.roots_y < 1 || shape.roots_x > kMaxSamples >> shape.root_log2 ||
                         shape.roots_y > kMaxSamples >> shape.root_log2))
    return refuse(std::to_string(shape.roots_x) + " x " + std::to_string(shape.roots_y) +
                  " roots are none or too many");
  if (shape.sparse_levels > 2 * shape.root_log2 - 2)
    return refuse(std::to_string(shape.sparse_levels) + " sparse levels of " + std::to_string(2 * shape.root_log2 - 1) +
                  "; the first one is whole");
  GridTopology grid;
  grid.shape_ = shape;
  if (shape.samples_x < 2 || shape.samples_y < 2 || shape.samples_x > grid.maxX() + 1 ||
      shape.samples_y > grid.maxY() + 1)
    return refuse(std::to_string(shape.samples_x) + " x " + std::to_string(shape.samples_y) +
                  " samples do not fit its roots");

  if (!shape.is_cube && uint64_t{grid.maxX()} * grid.maxY() > kMaxPositions)
    return refuse(std::to_string(grid.maxX()) + " x " + std::to_string(grid.maxY()) +
                  " sample intervals; up to 2^37 are supported");
  Slot offset = 0;
  for (int level = 1; level <= grid.maxLevel(); ++level) {
    const bool sides = level & 1, has_far_sides = sides && !shape.is_cube;
    const uint64_t tiles_x = (cellsAlong(shape.roots_x, level, has_far_sides) + kTile - 1) / kTile;
    const uint64_t tiles_y = (cellsAlong(shape.roots_y, level, has_far_sides) + kTile - 1) / kTile;
    grid.tiles_x_[level] = static_cast<uint32_t>(tiles_x);
    grid.inverse_tiles_x_[level] = 1.0 / static_cast<double>(tiles_x);
    grid.level_offset_[level] = offset;
    offset += tiles_x * tiles_y * kTile * kTile * (sides ? 2 : 1);
    if (level <= grid.wholeLevels() && offset >= kMaxWholeSlots) return refuse("more than 2^32 nodes on whole levels");
  }
  grid.level_offset_[grid.maxLevel() + 1] = offset;
  for (int width = 0, level = 1; width <= kSlotBits; ++width) {
    const Slot least = width == 0 ? 0 : Slot{1} << (width - 1);
    while (level < grid.maxLevel() && least >= grid.level_offset_[level + 1]) ++level;
    grid.level_hint_[width] = level;
  }
  return grid;
}

GridShape GridTopology::shapeFor(uint32_t samples_x, uint32_t samples_y) {
  CHECK_GE(samples_x, 2u);
  CHECK_GE(samples_y, 2u);
  const uint32_t longest = std::max(samples_x, samples_y) - 1;
  uint32_t k = 1;
  while (k < kMaxRootLog2 && (8u << k) < longest) ++k;
  const auto roots = [k](uint32_t samples) { return (samples - 2) / (1u << k) + 1; };
  return {roots(samples_x), roots(samples_y), k, samples_x, samples_y};
}

NodeList<2> GridTopology::cubeApexes(NodeId n, int level) const {
  const uint32_t t = scaleLog2At(level), s = 1u << t, x = n.x(), y = n.y(), along_x = 0 - (x >> t & 1),
                 dx = isCentreLevel(level) ? s : s & ~along_x,
                 dy = isCentreLevel(level) ? 0 - rise(x, y, t) : s & along_x;
  NodeList<2> result;
  result.push(moved(n, 0 - dx, 0 - dy));
  result.push(moved(n, dx, dy));
  return result;
}

NodeList<4> GridTopology::cubeChildren(NodeId n, int level) const {
  const uint32_t t = scaleLog2At(level), s = 1u << t, h = s >> 1;
  NodeList<4> result;
  if (isCentreLevel(level)) {
    for (const auto& [dx, dy] : {std::array{0 - s, 0u}, {s, 0u}, {0u, 0 - s}, {0u, s}}) result.push(moved(n, dx, dy));
  } else if (t > 0) {
    for (const auto& [dx, dy] : {std::array{0 - h, 0 - h}, {h, 0 - h}, {0 - h, h}, {h, h}})
      result.push(moved(n, dx, dy));
  }
  return result;
}

}  // namespace foreland::proto
