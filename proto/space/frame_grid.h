// Positions of lattice vertices by table look-up: bit-identical to FrameTransform::toScene, without its trigonometry.
// Costs 24 bytes per column and 32 per row of a geographic scene, nothing for a planar one. Immutable; any thread.
#pragma once

#include <vector>

#include "proto/space/frame.h"
#include "proto/topology/node.h"

namespace foreland::proto {

class FrameGrid {
 public:
  // Tables for lattice positions 0..max_x, 0..max_y.
  FrameGrid(const Frame& frame, uint32_t max_x, uint32_t max_y);

  const FrameTransform& transform() const { return transform_; }

  // Scene position of lattice vertex (x, y) at `height` steps.
  glm::dvec3 position(NodeId v, int32_t height) const {
    const double height_m = height * step_m_;
    if (columns_.empty()) {
      const double dx = v.x() - frame().anchor.x, dy = v.y() - frame().anchor.y;
      return {dx * frame().axis_x_m.x + dy * frame().axis_y_m.x, dx * frame().axis_x_m.y + dy * frame().axis_y_m.y,
              height_m};
    }
    return transform_.fromTables(rows_[v.y()], columns_[v.x()], height_m);
  }

 private:
  const Frame& frame() const { return transform_.frame(); }

  FrameTransform transform_;
  double step_m_;
  std::vector<FrameTransform::Row> rows_;
  std::vector<FrameTransform::Column> columns_;
};

}  // namespace foreland::proto
