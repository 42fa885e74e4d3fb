// Weights that tell the next attempt which parts of the original matter more: those from which the last attempt was
// far, or where it folded. One owner.
#pragma once

#include <compare>
#include <span>
#include <vector>

#include "terrain/compare/closest.h"
#include "terrain/remesh/original/original.h"
#include "terrain/remesh/original/surface_point.h"

namespace foreland::terrain {

class Importance {
 public:
  Importance(const Original& original, unsigned threads);

  std::span<const double> weights() const { return weights_; }  // of each vertex; 1 before the first update

  // Attempts without folded triangles are better than those with; then the smaller distance is better.
  struct AttemptCost {
    bool is_folded = true;
    double distance = 0;  // the largest from a vertex of the original to the attempt, raised by each folded triangle
    auto operator<=>(const AttemptCost&) const = default;
  };
  // Raises the weights where this attempt is bad, and rates it.
  AttemptCost update(const std::vector<Triangle>& triangles, const std::vector<glm::dvec3>& positions,
                     const std::vector<SurfacePoint>& points);

 private:
  void spread(std::vector<double>& shares) const;

  const Original& original_;
  unsigned threads_;
  ClosestPoint surface_;  // the original
  std::vector<double> weights_;
};

}  // namespace foreland::terrain
