// Positions of terrain nodes relative to the eye, for planar and for curved frames. Refinement from scratch and
// adaptation both use exactly these, so that they agree to the last bit. Immutable while a view lasts; any thread.
#pragma once

#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "proto/refine/metric/metric.h"
#include "proto/refine/metric/terrain_domain.h"

namespace foreland::proto {

// In a planar scene positions are affine in lattice position and height; the coefficients combine frame, eye and
// rotation.
class PlanarPositions {
 public:
  PlanarPositions(const TerrainDomain& domain, const Metric& metric) {
    const Frame& f = domain.frame.transform().frame();
    const Frustum& view = metric.frustum();
    const glm::dvec3 ax(f.axis_x_m, 0), ay(f.axis_y_m, 0), ah(0, 0, f.height_quantum_m);
    const glm::dvec3 base = -f.anchor.x * ax - f.anchor.y * ay - metric.eye();
    const std::array<glm::dvec3, 5> rows{view.right(), view.up(), view.forward(), {1, 0, 0}, {0, 1, 0}};
    for (size_t i = 0; i < rows.size(); ++i)
      k_[i] = {glm::dot(rows[i], ax), glm::dot(rows[i], ay), glm::dot(rows[i], ah), glm::dot(rows[i], base)};
  }
  [[gnu::always_inline]] NodePosition operator()(int32_t lattice_x, int32_t lattice_y, int32_t height) const {
    const double x = lattice_x, y = lattice_y, h = height;
    const double east = row(3, x, y, h), north = row(4, x, y, h);
    return {{row(0, x, y, h), row(1, x, y, h), row(2, x, y, h)}, std::sqrt(east * east + north * north)};
  }

  // The coefficients of lattice position and height, and a constant: of the position in the view, and of its parts
  // along the ground.
  const std::array<std::array<double, 4>, 5>& rows() const { return k_; }

 private:
  [[gnu::always_inline]] double row(size_t i, double x, double y, double h) const {
    return k_[i][0] * x + k_[i][1] * y + k_[i][2] * h + k_[i][3];
  }
  std::array<std::array<double, 4>, 5> k_;
};

class CurvedPositions {
 public:
  CurvedPositions(const TerrainDomain& domain, const Metric& metric) : frame_(domain.frame), metric_(metric) {}
  [[gnu::always_inline]] NodePosition operator()(int32_t lattice_x, int32_t lattice_y, int32_t height) const {
    const glm::dvec3 p =
        frame_.position(NodeId::at(static_cast<uint32_t>(lattice_x), static_cast<uint32_t>(lattice_y)), height) -
        metric_.eye();
    return {metric_.frustum().toView(p.x, p.y, p.z), std::sqrt(p.x * p.x + p.y * p.y)};
  }

 private:
  const FrameGrid& frame_;
  const Metric& metric_;
};

}  // namespace foreland::proto
