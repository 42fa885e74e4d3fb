// How a vertex bends (BlendMesh::from_bends) where more than two keyframes are blended. A control between a mesh's
// ends is a surface like these: with the controls of the nodes' weights, and on the ground as far as it has moved by
// then. Positions are linear in the weights, and so bends follow from the endpoints' as positions do:
//   bend(v) = (bend(a) + bend(b)) / 2 + what v's own weight and displacement add.
// Nodes at rest, whose ancestors are at rest as well, do not bend. Pure; any thread.
#pragma once

#include "client/mesh/patch/keyframe_mesh.h"
#include "client/mesh/weights/morphs.h"

namespace foreland::client {

struct CurveBend {
  glm::dvec3 from{0}, to{0};
};

inline CurveBend mixOf(const CurveBend& a, const CurveBend& b, double share) {
  return {a.from + share * (b.from - a.from), a.to + share * (b.to - a.to)};
}

// Of a node in transition; `a` and `b` are its edge's endpoints', `from` and `to` its displacement at the mesh's ends.
inline CurveBend bendOf(const CurveBend& a, const CurveBend& b, const Morph& m, uint32_t order, const glm::dvec3& from,
                        const glm::dvec3& to) {
  const auto [first, second] = m.controls(order);
  return {0.5 * (a.from + b.from) + 2 * (first - m.from) * from + (first - m.to) * to,
          0.5 * (a.to + b.to) + (second - m.from) * from + 2 * (second - m.to) * to};
}

}  // namespace foreland::client
