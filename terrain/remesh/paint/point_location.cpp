#include "terrain/remesh/paint/point_location.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "terrain/remesh/original/trace_geodesic.h"

namespace foreland::terrain {

namespace {

constexpr int kTraces = 4;  // towards the wanted position; the second one almost reaches it

}  // namespace

SurfacePoint locateOnOriginal(const Original& original, const Remeshed& remeshed, uint32_t face,
                              const glm::dvec3& weights) {
  const LatticeCell cell = remeshed.lattice.cellAt(face, weights);
  glm::dvec3 wanted(0);
  int nearest = 0;
  for (int k = 0; k < 3; ++k) {
    wanted += cell.weights[k] * remeshed.positions[cell.vertices[static_cast<size_t>(k)]];
    if (cell.weights[k] > cell.weights[nearest]) nearest = k;
  }
  SurfacePoint at = remeshed.points[cell.vertices[static_cast<size_t>(nearest)]];
  for (int i = 0; i < kTraces; ++i)
    at = traceGeodesic(original, original.twins, at, wanted - positionOf(at, original.positions, original.faces));
  return at;
}

}  // namespace foreland::terrain
