// Surfaces from formulas: for demos, measurements and tests. Pure; any thread.
#pragma once

#include "terrain/surface/surface.h"

namespace foreland::terrain {

// How finely a shape is made.
struct ShapeDetail {
  proto::MeshRule rule = proto::MeshRule::kQuadrisection;
  uint32_t halvings = 5;
  double quantum_m = 1e-6;
};

// About the origin, from the octahedron's eight faces, each new vertex above the middle of its edge: the sphere of S,
// section 4, has 8,192 faces at five halvings. `radius_m` is positive.
Result<TrueSurface> makeSphere(double radius_m, const ShapeDetail& detail);

// About the z axis, from `columns` around the axis by `rows` around the tube of squares cut in two; at least three
// each. Each new vertex is the point of the torus next to the middle of its edge. 0 < tube_m < ring_m.
struct TorusShape {
  double ring_m = 2, tube_m = 1;
  uint32_t columns = 8, rows = 4;
};
Result<TrueSurface> makeTorus(const TorusShape& shape, const ShapeDetail& detail);

}  // namespace foreland::terrain
