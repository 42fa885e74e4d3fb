// A crease or a piece of border, parametrised by arc length, along which lattice vertices slide. Immutable; any thread.
#pragma once

#include <vector>

#include "terrain/remesh/original/creases.h"
#include "terrain/remesh/original/surface_point.h"

namespace foreland::terrain {

class FeatureCurve {
 public:
  FeatureCurve(const Original& surface, Chain chain);

  double length() const { return lengths_.back(); }
  // The point at arc length `along` from the start, in the model's units, clamped to the ends.
  SurfacePoint at(double along) const;
  glm::dvec3 direction(double along) const;  // a unit vector
  // Arc length of the curve's point nearest to `p`. Cost: linear in its edges.
  double nearest(const glm::dvec3& p) const;

 private:
  size_t edgeAt(double along) const;

  const Original& surface_;
  Chain chain_;
  std::vector<double> lengths_;  // arc length from the start to each vertex of the chain
};

}  // namespace foreland::terrain
