// The terrain of a scene as a function of the ground plane, by its finest triangles alone, and whether it blocks a line
// of sight, by marching along it. Knows neither rays nor occluders.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <utility>
#include <vector>

#include "server/section/hierarchy.h"

namespace foreland::test {

class HeightField {
 public:
  explicit HeightField(const server::Hierarchy& hierarchy) : hierarchy_(hierarchy) {}
  // At a scene time: `shares` of the ground at each epoch.
  HeightField(const server::Hierarchy& hierarchy, std::vector<double> shares)
      : hierarchy_(hierarchy), shares_(std::move(shares)) {}

  // Metres at a lattice position inside the data: squares of two samples are cut into eight triangles about their
  // middles.
  double at(double x, double y) const {
    const proto::GridShape& shape = hierarchy_.grid().shape();
    const auto cell = [](double v, uint32_t samples) {
      return static_cast<uint32_t>(std::min(std::max(0.0, std::floor(v)), samples - 2.0));
    };
    const uint32_t i = cell(x, shape.samples_x), j = cell(y, shape.samples_y);
    const double u = x - i, v = y - j;
    const double a = sample(i, j), b = sample(i + 1, j), c = sample(i, j + 1), d = sample(i + 1, j + 1);
    if ((i + j) % 2 == 0) return u > v ? a + u * (b - a) + v * (d - b) : a + v * (c - a) + u * (d - c);
    return u + v < 1 ? a + u * (b - a) + v * (c - a) : d + (1 - u) * (c - d) + (1 - v) * (b - d);
  }

  // Whether the segment stays above the terrain: by `clearance_m`, or by 2 mm for each metre of the rest of its way
  // where that is less. So a point on the ground can be seen, unless at a grazing angle.
  bool isClear(const glm::dvec3& from, const glm::dvec3& to, double clearance_m) const {
    const auto transform = hierarchy_.frame().transform();
    const proto::LatticePosition p = transform.toLattice(from), q = transform.toLattice(to);
    const double samples = std::hypot(q.x - p.x, q.y - p.y);
    const int steps = static_cast<int>(8 * samples) + 20;
    const double length_m = glm::distance(from, to);
    for (int k = 0; k < steps; ++k) {
      const double share = static_cast<double>(k) / steps;
      const proto::LatticePosition at_share = transform.toLattice(from + share * (to - from));
      if (at_share.x < 0 || at_share.y < 0 || at_share.x > hierarchy_.grid().shape().samples_x - 1 ||
          at_share.y > hierarchy_.grid().shape().samples_y - 1)
        continue;
      if (at_share.height_m < at(at_share.x, at_share.y) + std::min(clearance_m, 0.002 * (1 - share) * length_m))
        return false;
    }
    return true;
  }

 private:
  double sample(uint32_t x, uint32_t y) const {
    const proto::NodeId v = proto::NodeId::at(x, y);
    double quanta = hierarchy_.scene().height(v);
    for (uint32_t epoch = 0; epoch < shares_.size(); ++epoch)
      if (shares_[epoch] != 0) quanta += shares_[epoch] * hierarchy_.epochs().offset(epoch, hierarchy_.grid(), v);
    return quanta * hierarchy_.frame().transform().frame().height_quantum_m;
  }

  const server::Hierarchy& hierarchy_;
  std::vector<double> shares_;
};

}  // namespace foreland::test
