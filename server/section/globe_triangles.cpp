#include "server/section/globe_triangles.h"

#include "base/check.h"

namespace foreland::server {

namespace {

// What errors leave out (terrain/bounds/error.h), many times over.
constexpr double kErrorPad_m = 1e-6;

}  // namespace

GlobeTriangles::GlobeTriangles(const Hierarchy& hierarchy)
    : grid_(hierarchy.grid()), nodes_(hierarchy.table()), side_(static_cast<int32_t>(hierarchy.grid().rootSize())) {
  CHECK_TRUE(grid_.isCube());
}

GlobeTriangles::Vertex GlobeTriangles::base(uint32_t face, int32_t x, int32_t y) const {
  const proto::NodeId name = grid_.cube().name({face, x, y});
  return {x, y, name, nodes_.height(name)};
}

std::optional<GlobeTriangles::Node> GlobeTriangles::halfway(uint32_t face, int32_t ax, int32_t ay, int32_t bx,
                                                            int32_t by, int level) const {
  const int32_t x = ax + bx, y = ay + by;
  if (((x | y) & 1) != 0) return std::nullopt;
  const proto::NodeId name = grid_.cube().name({face, x / 2, y / 2});
  const proto::Slot slot = grid_.slot(name, level);
  if (!nodes_.hasPage(slot)) return std::nullopt;
  const proto::NodeRecord& record = nodes_.at(slot);
  return Node{{x / 2, y / 2, name, record.height()}, record.error().metres() + kErrorPad_m};
}

}  // namespace foreland::server
