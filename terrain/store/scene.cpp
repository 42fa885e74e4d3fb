#include "terrain/store/scene.h"

#include <algorithm>
#include <cmath>

#include "terrain/store/mapped_scene.h"

namespace foreland::terrain {

using proto::NodeId;

Result<std::shared_ptr<const Scene>> Scene::open(const std::filesystem::path& path) {
  auto scene = MappedScene::open(path);
  if (!scene.ok()) return scene.error();
  return std::shared_ptr<const Scene>(std::move(*scene));
}

Status Scene::adoptPages(std::span<const proto::PageBlock> blocks) {
  auto directory = proto::PageDirectory::create(grid_, blocks);
  if (!directory) return directory.error();
  directory_ = std::move(*directory);
  return {};
}

int32_t Scene::height(proto::NodeId v) const {
  const int level = grid_.level(v);
  if (level == 0) return baseHeight(v);
  const proto::Slot slot = grid_.slot(v, level);
  if (!isSparse()) return records_[slot].height();
  const uint64_t place = directory_.placeOf(slot);
  return place == proto::PageDirectory::kNowhere ? interpolated(v) : records_[place].height();
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

int32_t Scene::interpolated(NodeId v) const {
  Halved t = rootTriangle(grid_, v);
  const uint32_t root_x = t.apex.x() >> grid_.shape().root_log2;
  const auto nameOf = [&](NodeId corner) { return grid_.nameIn(root_x, corner); };
  for (int level = 1; level <= grid_.maxLevel() && directory_.hasPage(grid_.slot(nameOf(t.middle()), level)); ++level)
    t = t.halfWith(v);
  const auto all = static_cast<double>(doubleArea(t.a, t.b, t.apex));
  const double sum = static_cast<double>(doubleArea(v, t.b, t.apex)) * height(nameOf(t.a)) +
                     static_cast<double>(doubleArea(t.a, v, t.apex)) * height(nameOf(t.b)) +
                     static_cast<double>(doubleArea(t.a, t.b, v)) * height(nameOf(t.apex));
  return static_cast<int32_t>(std::nearbyint(sum / all));
}

int32_t Scene::baseHeight(NodeId v) const {
  const uint32_t k = grid_.shape().root_log2, x = v.x() >> k, y = v.y() >> k;
  if (grid_.scaleLog2(v) >= k) return corners_[static_cast<size_t>(y) * (grid_.shape().roots_x + 1) + x];
  return centres_[static_cast<size_t>(y) * grid_.shape().roots_x + x];
}

}  // namespace foreland::terrain
