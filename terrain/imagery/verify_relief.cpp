#include "terrain/imagery/verify_relief.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "proto/imagery/relief_codec.h"
#include "proto/space/frame_grid.h"
#include "terrain/imagery/normal_cone.h"
#include "terrain/parallel.h"

namespace foreland::terrain {

namespace {

using proto::kTileGutter;
using proto::kTilePayload;
using proto::kTileSide;
using proto::TileId;

constexpr double kStepRounding = 1e-6;  // of a step

// Texel i of a tile on its level's raster, which ends at `count`.
int64_t unclamped(uint32_t tile_at, uint32_t i) { return int64_t{tile_at} * kTilePayload + i - kTileGutter; }
uint32_t clamped(uint32_t tile_at, uint32_t i, uint32_t count) {
  return static_cast<uint32_t>(std::clamp<int64_t>(unclamped(tile_at, i), 0, int64_t{count} - 1));
}

struct Angles {
  double squares = 0, largest = 0;
  uint64_t count = 0;
};

class ReliefCheck {
 public:
  ReliefCheck(const Scene& scene, uint8_t layer, Faults& faults)
      : scene_(scene),
        tiles_(scene.tiles()),
        layer_(tiles_.layers()[layer]),
        faults_(faults),
        positions_(scene.frame(), scene.grid().maxX(), scene.grid().maxY()),
        rounding_m_(scene.isSparse() ? scene.frame().height_quantum_m : 0) {}

  struct Scratch {
    std::vector<int32_t> steps = std::vector<int32_t>(proto::kTileTexels), finer = steps;
    std::vector<glm::dvec3> data = std::vector<glm::dvec3>(proto::kTileTexels), relief = data;
  };

  Angles check(const TileId& tile, uint64_t order, Scratch& scratch) const {
    const auto fault = [&](const std::string& what) { faults_.add(order, nameOf(tile) + " " + what); };
    const auto bounds = tiles_.bounds(tile);
    if (!bounds) return {};  // the directory's check says so
    if (const Status s = proto::decodeRelief(tiles_.bytes(tile), scratch.steps); !s.ok()) {
      fault("cannot be decoded");
      return {};
    }
    if (tile.level > 0) {
      checkChildrensBounds(tiles_, tile, order, faults_);
      if (!isMeanOfFiner(tile, scratch)) fault("is not the mean of those of the finer level");
      return {};
    }
    if (!isOfSamples(tile, *bounds, scratch)) {
      fault("has heights that are not those of the samples, or not within its bounds");
      return {};
    }
    return checkNormals(tile, NormalCone::of(*bounds), scratch, fault);
  }

 private:
  double step(uint32_t level) const { return layer_.stepAt(level); }

  bool isOfSamples(const TileId& tile, const proto::TileBounds& bounds, const Scratch& scratch) const {
    const double max_m = layer_.step_m * (0.5 + kStepRounding) + rounding_m_,
                 quantum_m = scene_.frame().height_quantum_m;
    size_t i = 0;
    for (uint32_t y = 0; y < kTileSide; ++y)
      for (uint32_t x = 0; x < kTileSide; ++x, ++i) {
        const auto n = proto::NodeId::at(clamped(tile.x, x, layer_.width), clamped(tile.y, y, layer_.height));
        const double height_m = scene_.height(n) * quantum_m;
        if (!(std::abs(scratch.steps[i] * layer_.step_m - height_m) <= max_m)) return false;
        if (isOwn(tile, x, y) && !(height_m >= bounds.lowest_m && height_m <= bounds.highest_m)) return false;
      }
    return true;
  }

  // Whether a texel is neither of the gutter nor beyond the raster.
  bool isOwn(const TileId& tile, uint32_t x, uint32_t y) const {
    const auto within = [](uint32_t at, uint32_t i, uint32_t count) {
      return i >= kTileGutter && i < kTileSide - kTileGutter && unclamped(at, i) < count;
    };
    return within(tile.x, x, layer_.widthAt(tile.level)) && within(tile.y, y, layer_.heightAt(tile.level));
  }

  bool isMeanOfFiner(const TileId& tile, Scratch& scratch) const {
    for (uint32_t k = 0; k < 4; ++k) {
      const TileId child = tile.child(k);
      if (!layer_.has(child) || !tiles_.bounds(child)) continue;
      if (!proto::decodeRelief(tiles_.bytes(child), scratch.finer).ok()) continue;  // its own check says so
      if (!isMeanOf(child, scratch)) return false;
    }
    return true;
  }
  // Of a half-size image.
  static bool isPayload(uint32_t i) { return i >= kTileGutter / 2 && i < (kTileSide - kTileGutter) / 2; }
  // Whether the texel (x, y) of the level above a tile's is in a tile that is there. Sparse scenes lack some, and then
  // its neighbours' gutters hold the ground at the texel's middle, which is not the mean of what the finer level has.
  // Where the finer tile alone lacks its neighbour, its gutter and the parent's own texel are of the same ground.
  bool isStored(const TileId& tile, int64_t x, int64_t y) const {
    return !scene_.isSparse() || tiles_.bounds({tile.layer, static_cast<uint8_t>(tile.level + 1),
                                                static_cast<uint32_t>(x) / proto::kTilePayload,
                                                static_cast<uint32_t>(y) / proto::kTilePayload});
  }
  // Compares the half-size image of a tile with the quadrant of its parent. Beyond the raster both repeat its border,
  // so they need not agree.
  bool isMeanOf(const TileId& child, const Scratch& scratch) const {
    const uint32_t width = layer_.widthAt(child.level), height = layer_.heightAt(child.level);
    const uint32_t left = child.x % 2 ? kTileSide / 2 - kTileGutter / 2 : kTileGutter / 2,
                   below = child.y % 2 ? kTileSide / 2 - kTileGutter / 2 : kTileGutter / 2;
    const double max_m = (0.5 + kStepRounding) * (step(child.level) + step(child.level + 1u)) + rounding_m_;
    for (uint32_t y = 0; y < kTileSide / 2; ++y)
      for (uint32_t x = 0; x < kTileSide / 2; ++x) {
        const int64_t east = unclamped(child.x, 2 * x + 1), north = unclamped(child.y, 2 * y + 1);
        if (east < 1 || north < 1 || east >= width || north >= height) continue;
        if (!(isPayload(x) && isPayload(y)) && !isStored(child, (east - 1) / 2, (north - 1) / 2)) continue;
        const int32_t* fine = &scratch.finer[size_t{2 * y} * kTileSide + 2 * x];
        const double mean = 0.25 * (int64_t{fine[0]} + fine[1] + fine[kTileSide] + fine[kTileSide + 1]);
        const double own = scratch.steps[size_t{below + y} * kTileSide + left + x];
        if (!(std::abs(own * step(child.level + 1u) - mean * step(child.level)) <= max_m)) return false;
      }
    return true;
  }

  // Whether the sample of a texel has neighbours on all sides.
  bool isInside(const TileId& tile, uint32_t x, uint32_t y) const {
    const auto within = [](int64_t at, uint32_t count) { return at > 0 && at + 1 < count; };
    return within(unclamped(tile.x, x), layer_.width) && within(unclamped(tile.y, y), layer_.height);
  }

  template <class Fault>
  Angles checkNormals(const TileId& tile, const NormalCone& cone, Scratch& scratch, const Fault& fault) const {
    setPositions(tile, scratch);
    Angles angles;
    bool all_within = true;
    for (uint32_t y = kTileGutter; y < kTileSide - kTileGutter; ++y)
      for (uint32_t x = kTileGutter; x < kTileSide - kTileGutter; ++x) {
        if (!isOwn(tile, x, y)) continue;
        const size_t i = size_t{y} * kTileSide + x;
        const glm::dvec3 data = normalAt(scratch.data, i), relief = normalAt(scratch.relief, i);
        all_within = all_within && cone.holds(data);
        if (!isInside(tile, x, y)) continue;
        const double angle = std::atan2(glm::length(glm::cross(data, relief)), glm::dot(data, relief));
        angles.squares += angle * angle, angles.largest = std::max(angles.largest, angle), ++angles.count;
      }
    if (!all_within) fault("has normals outside its cone");
    return angles;
  }
  void setPositions(const TileId& tile, Scratch& scratch) const {
    const double quanta = layer_.step_m / scene_.frame().height_quantum_m;
    size_t i = 0;
    for (uint32_t y = 0; y < kTileSide; ++y)
      for (uint32_t x = 0; x < kTileSide; ++x, ++i) {
        const auto n = proto::NodeId::at(clamped(tile.x, x, layer_.width), clamped(tile.y, y, layer_.height));
        scratch.data[i] = positions_.position(n, scene_.height(n));
        scratch.relief[i] = positions_.position(n, scratch.steps[i] * quanta);
      }
  }
  // By central differences; at the raster's border, where positions repeat, by differences to one side.
  static glm::dvec3 normalAt(const std::vector<glm::dvec3>& p, size_t i) {
    return glm::normalize(glm::cross(p[i + 1] - p[i - 1], p[i + kTileSide] - p[i - kTileSide]));
  }

  const Scene& scene_;
  const TileTable& tiles_;
  const proto::TileLayer& layer_;
  Faults& faults_;
  proto::FrameGrid positions_;
  double rounding_m_;  // of heights between nodes of a sparse scene, which tiles take as they are
};

bool fits(const Scene& scene, const proto::TileLayer& layer) {
  const proto::GridShape& shape = scene.grid().shape();
  return layer.width == shape.samples_x && layer.height == shape.samples_y && layer.texel == 1 &&
         layer.origin == glm::dvec2(-0.5, -0.5);
}

}  // namespace

LayerReport verifyRelief(const Scene& scene, uint8_t layer, unsigned threads, Faults& faults) {
  LayerReport report{.content = proto::TileContent::kRelief};
  if (!fits(scene, scene.tiles().layers()[layer])) {
    faults.add(0, "the layer of relief does not fit the samples");
    return report;
  }
  std::vector<TileId> ids;
  scene.tiles().forEach(layer, [&](const TileId& id) { ids.push_back(id); });
  const ReliefCheck checker(scene, layer, faults);
  std::vector<ReliefCheck::Scratch> scratch(threadCount(threads));
  std::vector<Angles> angles(ids.size());
  parallelFor(
      ids.size(), threads, [&](uint64_t i, unsigned worker) { angles[i] = checker.check(ids[i], i, scratch[worker]); },
      [](uint64_t) { return true; });
  Angles all;
  for (const Angles& a : angles) {
    all.squares += a.squares, all.largest = std::max(all.largest, a.largest), all.count += a.count;
  }
  for (const TileId& id : ids) report.tiles += scene.tiles().bounds(id) ? 1 : 0;
  report.rms_rad = all.count ? std::sqrt(all.squares / static_cast<double>(all.count)) : 0;
  report.largest_rad = all.largest;
  return report;
}

}  // namespace foreland::terrain
