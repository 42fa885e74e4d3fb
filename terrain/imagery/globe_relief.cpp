#include "terrain/imagery/globe_relief.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "proto/imagery/relief_codec.h"
#include "proto/space/cube_map.h"
#include "terrain/imagery/ground_bounds.h"
#include "terrain/imagery/tile_tree.h"

namespace foreland::terrain {

using proto::GridTopology;
using proto::kTilePayload;
using proto::NodeId;
using proto::TileId;

proto::TileLayer globeReliefLayer(const proto::Frame& frame) {
  proto::TileLayer layer = reliefLayer(frame.face_steps, frame.face_steps, frame);
  layer.origin = {0, 0};
  layer.face_steps = frame.face_steps;
  return layer;
}

FacePlace placeBeyond(const FaceTexel& t, int64_t side) {
  const double step = 2.0 / static_cast<double>(side);
  const auto coordinate = [&](int64_t i) { return (static_cast<double>(i) + 0.5) * step - 1; };
  const proto::CubePoint at = proto::cubePoint(proto::cubeVector({t.face, coordinate(t.x), coordinate(t.y)}));
  return {at.face, (at.s + 1) / step, (at.t + 1) / step};
}

float GlobeReliefSource::at(uint32_t level, uint32_t face, uint32_t x, uint32_t y) const {
  double sum = 0;
  for (uint32_t k = 0; k < 4; ++k)
    sum += ground_.exactAt(ground_.grid().nameIn(
        face, NodeId::at(face * layer_.face_steps + ((x + k % 2) << level), (y + k / 2) << level)));
  return static_cast<float>(0.25 * sum);
}

namespace {

// Tiles of a level in which there are nodes of it, and their neighbours where a node is on the border.
class ReliefTiles {
 public:
  ReliefTiles(const proto::TileLayer& layer, uint8_t index) : layer_(layer), index_(index) {}

  std::set<uint64_t> of(const GridTopology& grid, const proto::PageDirectory& pages) {
    for (uint32_t level = grid.shape().sparse_levels / 2; level < layer_.levels(); ++level)
      for (uint32_t face = 0; face < layer_.faces(); ++face) {
        const double side = layer_.widthAt(level);
        add(level, {face, {0, 0}, {side - 1, side - 1}});
      }
    pages.forEachPage([&](proto::Slot first, uint64_t) { addPage(grid, grid.pagePlace(first)); });
    return std::move(keys_);
  }

 private:
  void addPage(const GridTopology& grid, const proto::PagePlace& page) {
    const uint32_t scale = grid.shape().root_log2 - 1 - static_cast<uint32_t>(page.level) / 2;
    if (scale >= layer_.levels()) return;
    const uint32_t side = layer_.widthAt(scale), column = page.column * GridTopology::kTileSide,
                   height = GridTopology::kTileSide >> (page.level % 2), face = column / side;
    const double x = column % side, y = page.row * height, last = side - 1.0;
    if (face >= layer_.faces()) return;
    const FaceBox around{face, {x - 1, y - 1}, {x + GridTopology::kTileSide + 1, y + height + 1}};
    add(scale, {face, glm::max(around.low, glm::dvec2(0)), glm::min(around.high, glm::dvec2(last))});
    // Of a row of texels along the side, in the middles of these.
    const auto beyond = [&](const glm::dvec2& low, const glm::dvec2& high) {
      const FaceBox there = foldedOver(FaceBox{face, low + 0.5, high + 0.5}, side);
      add(scale, {there.face, there.low - 0.5, there.high - 0.5});
    };
    const double west = std::max(around.low.x, 0.0), east = std::min(around.high.x, last),
                 south = std::max(around.low.y, 0.0), north = std::min(around.high.y, last);
    if (around.low.x < 0) beyond({-1, south}, {-1, north});
    if (around.high.x > last) beyond({side, south}, {side, north});
    if (around.low.y < 0) beyond({west, -1}, {east, -1});
    if (around.high.y > last) beyond({west, side}, {east, side});
  }
  // With the texels of both corners.
  void add(uint32_t level, const FaceBox& texels) {
    const auto tileOf = [](double texel) { return static_cast<uint32_t>(texel) / kTilePayload; };
    for (uint32_t y = tileOf(texels.low.y); y <= tileOf(texels.high.y); ++y)
      for (uint32_t x = tileOf(texels.low.x); x <= tileOf(texels.high.x); ++x)
        keys_.insert(TileId{index_, static_cast<uint8_t>(level), layer_.xOf(level, texels.face, x), y}.key());
  }

  const proto::TileLayer& layer_;
  uint8_t index_;
  std::set<uint64_t> keys_;
};

}  // namespace

Result<bool> addGlobeRelief(const StoredHeights& ground, const SparseGroundBounds& bounds, const proto::Frame& frame,
                            const std::filesystem::path& target, unsigned threads, const KeepGoing& keepGoing,
                            TileSection& section) {
  const proto::TileLayer layer = globeReliefLayer(frame);
  if (Status s = layer.validate(); !s.ok()) return s.error();
  const uint8_t index = section.addLayer(layer);
  const WantedTiles wanted =
      closedUnderParents(layer, index, ReliefTiles(layer, index).of(ground.grid(), ground.pages()));
  const GlobeReliefSource source(ground, layer);
  const auto boundsOf = [&](const TileId& tile) {
    if (tile.level == 0) return bounds.over(layer.boxOf(tile));
    std::vector<proto::TileBounds> parts;
    for (uint32_t k = 0; k < 4; ++k)
      if (const TileId child = tile.child(k); layer.has(child))
        parts.push_back(section.has(child) ? section.bounds(child) : bounds.over(layer.boxOf(child)));
    return unionOf(std::span<const proto::TileBounds>(parts));
  };
  return TileTree(layer, index, source, threads)
      .make(wanted, target, keepGoing, [&](const TileId& tile, const std::vector<float>& texels, unsigned) {
        const double scale = frame.height_quantum_m / layer.stepAt(tile.level);
        std::vector<int32_t> steps(texels.size());
        std::ranges::transform(texels, steps.begin(), [&](float h) {
          return static_cast<int32_t>(std::nearbyint(static_cast<double>(h) * scale));
        });
        return section.add(tile, proto::encodeRelief(steps), boundsOf(tile), 0);
      });
}

}  // namespace foreland::terrain
