// A crease or a piece of border as a way to slide along. Immutable; any thread.
#pragma once

#include <vector>

#include "terrain/remesh/original/creases.h"
#include "terrain/remesh/original/surface_point.h"

namespace foreland::terrain {

class Rail {
 public:
  Rail(const Original& surface, Chain chain);

  double length() const { return lengths_.back(); }
  // The place `along` from the start, in metres of the model; the nearer end beyond the ends.
  SurfacePoint at(double along) const;
  glm::dvec3 direction(double along) const;  // a unit vector
  // How far along the nearest place of the rail lies. Linear in its edges.
  double nearest(const glm::dvec3& p) const;

 private:
  size_t edgeAt(double along) const;

  const Original& surface_;
  Chain chain_;
  std::vector<double> lengths_;  // from the start to each vertex of the chain
};

}  // namespace foreland::terrain
