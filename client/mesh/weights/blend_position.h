// Where a vertex is drawn: p_w(v) = (p_w(a) + p_w(b)) / 2 + w(v) d(v), with a and b the endpoints of the edge that the
// node v refines, d its displacement and w its weight (THEORY section 2). This is the only interpolator: terrain and
// objects, keyframes and geomorphs use it. With the weights 0 and 1 of a section the result is, to the last bit, the
// edge's midpoint or the node's true position.
#pragma once

#include <cstdint>
#include <glm/geometric.hpp>

namespace foreland::client {

// The position that a vertex is drawn at, and whether that is exactly its true position in the scene.
template <class Vector>
struct DrawnPosition {
  Vector position;
  bool is_true;
};

// `a` and `b` are the edge's endpoints as drawn. `truePosition()` and `displacement()` of the node are called only if
// the result depends on them.
template <class Vector, class TruePosition, class Displacement>
DrawnPosition<Vector> blendPosition(const DrawnPosition<Vector>& a, const DrawnPosition<Vector>& b, double weight,
                                    const TruePosition& truePosition, const Displacement& displacement) {
  if (weight == 1 && a.is_true && b.is_true) return {truePosition(), true};
  const Vector midpoint = 0.5 * (a.position + b.position);
  return {weight == 0 ? midpoint : midpoint + weight * displacement(), false};
}

}  // namespace foreland::client
