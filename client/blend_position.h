// Where a vertex is drawn: p_w(v) = (p_w(a) + p_w(b)) / 2 + w(v) d(v), with a and b the ends of the edge that the node
// refines, d its displacement and w its weight (DESIGN section 2). The one interpolator: terrain and objects, keyframes
// and geomorphs. With weights 0 and 1 of sections the result is the middle or the node's own place to the last bit.
#pragma once

#include <cstdint>
#include <glm/geometric.hpp>

namespace foreland::client {

// A vertex as it is drawn; `is_own`: at the very place that the node has in the scene.
template <class Vector>
struct Drawn {
  Vector at;
  bool is_own;
};

// `own()` and `displacement()` of the node are asked for only where they count.
template <class Vector, class Own, class Displacement>
Drawn<Vector> blendPosition(const Drawn<Vector>& a, const Drawn<Vector>& b, double weight, const Own& own,
                            const Displacement& displacement) {
  if (weight == 1 && a.is_own && b.is_own) return {own(), true};
  const Vector middle = 0.5 * (a.at + b.at);
  return {weight == 0 ? middle : middle + weight * displacement(), false};
}

}  // namespace foreland::client
