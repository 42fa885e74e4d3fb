#include "terrain/store/stored_heights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace foreland::terrain {

using proto::NodeId;

int32_t StoredHeights::at(NodeId v) const { return static_cast<int32_t>(std::nearbyint(exactAt(v))); }

double StoredHeights::exactAt(NodeId v) const {
  const int level = grid_.level(v);
  if (level == 0) return base_.at(grid_, v);
  const std::optional<int32_t> height = heightAt(grid_.slot(v, level));
  return height ? *height : interpolated(v, level);
}

std::optional<int32_t> StoredHeights::heightAt(proto::Slot slot) const {
  const uint64_t place = pages_.placeOf(slot);
  if (place == proto::PageDirectory::kNowhere) return std::nullopt;
  if (!supply_) return records_[place].height();
  proto::NodeRecord record;
  return supply_->read(records_, place, record) ? std::optional(record.height()) : std::nullopt;
}

namespace {

// Twice the area of the triangle (a, b, c); positive if it is counter-clockwise.
int64_t doubleArea(NodeId a, NodeId b, NodeId c) {
  const auto x = [](NodeId v) { return int64_t{v.x()}; };
  const auto y = [](NodeId v) { return int64_t{v.y()}; };
  return (x(b) - x(a)) * (y(c) - y(a)) - (y(b) - y(a)) * (x(c) - x(a));
}

// A triangle that is halved at the middle of the edge from a to b.
struct Halved {
  NodeId a, b, apex;

  NodeId middle() const { return NodeId::at((a.x() + b.x()) / 2, (a.y() + b.y()) / 2); }
  // The half that a point of the triangle lies in.
  Halved halfWith(NodeId v) const {
    const NodeId m = middle();
    const bool with_a = (doubleArea(m, apex, v) >= 0) == (doubleArea(m, apex, a) >= 0);
    return {with_a ? a : b, apex, m};
  }
};

// Of a root square, one of its four triangles that a point of the lattice lies in.
Halved rootTriangle(const proto::GridTopology& grid, NodeId v) {
  const proto::GridShape& shape = grid.shape();
  const uint32_t k = shape.root_log2, size = 1u << k, x0 = std::min(v.x() >> k, shape.roots_x - 1) << k,
                 y0 = std::min(v.y() >> k, shape.roots_y - 1) << k, dx = v.x() - x0, dy = v.y() - y0;
  const NodeId centre = NodeId::at(x0 + size / 2, y0 + size / 2);
  const bool below_rising = dy <= dx, below_falling = dy <= size - dx;
  const NodeId first = below_rising == below_falling ? NodeId::at(x0, y0 + (below_rising ? 0 : size))
                                                     : NodeId::at(x0 + (below_rising ? size : 0), y0);
  const NodeId second =
      below_rising == below_falling ? NodeId::at(first.x() + size, first.y()) : NodeId::at(first.x(), first.y() + size);
  return {first, second, centre};
}

}  // namespace

double StoredHeights::interpolated(NodeId v, int level) const {
  // Of each level the triangle around the node that a node of this level halves: of the last one, itself.
  std::array<Halved, proto::GridTopology::kMaxLevels> triangles;
  const std::span around(triangles.data(), static_cast<size_t>(level));
  around[0] = rootTriangle(grid_, v);
  for (size_t i = 1; i < around.size(); ++i) around[i] = around[i - 1].halfWith(v);
  const uint32_t root_x = around[0].apex.x() >> grid_.shape().root_log2;
  const auto nameOf = [&](NodeId corner) { return grid_.nameIn(root_x, corner); };
  const auto isHalved = [&](const Halved& t) {
    return heightAt(grid_.slot(nameOf(t.middle()), static_cast<int>(&t - around.data()) + 1)).has_value();
  };
  // Pages are closed under parents, so what is halved lies in triangles that are; but a supply may have lost any page.
  const std::span coarser = around.first(around.size() - 1);
  const auto finest =
      supply_ ? std::ranges::find_if_not(coarser, isHalved) : std::ranges::partition_point(coarser, isHalved);
  const Halved& t = around[static_cast<size_t>(finest - coarser.begin())];
  const auto all = static_cast<double>(doubleArea(t.a, t.b, t.apex));
  const double sum = static_cast<double>(doubleArea(v, t.b, t.apex)) * at(nameOf(t.a)) +
                     static_cast<double>(doubleArea(t.a, v, t.apex)) * at(nameOf(t.b)) +
                     static_cast<double>(doubleArea(t.a, t.b, v)) * at(nameOf(t.apex));
  return sum / all;
}

}  // namespace foreland::terrain
