// Positions of lattice vertices by table look-up: bit-identical to FrameTransform::toScene, without its trigonometry.
// Immutable; any thread. Memory: that of its GeographicTables.
#pragma once

#include "proto/space/frame.h"
#include "proto/space/geographic_tables.h"
#include "proto/topology/node.h"

namespace foreland::proto {

class FrameGrid {
 public:
  // Tables for lattice positions 0..max_x, 0..max_y.
  FrameGrid(const Frame& frame, uint32_t max_x, uint32_t max_y);

  const FrameTransform& transform() const { return transform_; }

  // Scene position of lattice vertex (x, y) at a height of `height` quanta.
  glm::dvec3 position(NodeId v, double height) const {
    const double height_m = height * height_quantum_m_;
    if (tables_.columns.empty()) {
      if (frame().kind == FrameKind::kGlobe) [[unlikely]]
        return transform_.vertexOfGlobe(v.x(), v.y(), height_m);
      const double dx = v.x() - frame().anchor.x, dy = v.y() - frame().anchor.y;
      return {dx * frame().axis_x_m.x + dy * frame().axis_y_m.x, dx * frame().axis_x_m.y + dy * frame().axis_y_m.y,
              height_m};
    }
    return transform_.fromTables(tables_.rows[v.y()], tables_.columns[v.x()], height_m);
  }

 private:
  const Frame& frame() const { return transform_.frame(); }

  FrameTransform transform_;
  double height_quantum_m_;
  GeographicTables tables_;
};

}  // namespace foreland::proto
