#include "terrain/remesh/original/trace_geodesic.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace foreland::terrain {

namespace {

using glm::dvec3;

constexpr int kMaxFaces = 1000;  // crossed by one line; rounding must not let it circle a vertex for ever

// How the barycentric weights in the face change along `step`.
dvec3 weightChange(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& step) {
  const dvec3 ab = b - a, ac = c - a;
  const double d00 = glm::dot(ab, ab), d01 = glm::dot(ab, ac), d11 = glm::dot(ac, ac);
  const double d20 = glm::dot(step, ab), d21 = glm::dot(step, ac), all = d00 * d11 - d01 * d01;
  const double wb = (d11 * d20 - d01 * d21) / all, wc = (d00 * d21 - d01 * d20) / all;
  return {-wb - wc, wb, wc};
}

}  // namespace

SurfacePoint traceGeodesic(const Original& surface, const std::vector<Triangle>& twins, SurfacePoint at, dvec3 step) {
  for (int crossed = 0; crossed < kMaxFaces; ++crossed) {
    const Triangle& t = surface.faces[at.face];
    const dvec3 corners[3] = {surface.positions[t[0]], surface.positions[t[1]], surface.positions[t[2]]};
    const dvec3 change = weightChange(corners[0], corners[1], corners[2], step);
    // The line leaves over the side opposite to the first corner whose weight becomes zero.
    int corner = -1;
    double part = 1;
    for (int k = 0; k < 3; ++k)
      if (change[k] < 0 && -at.weights[k] / change[k] < part) corner = k, part = -at.weights[k] / change[k];
    at.weights = cleanWeights(at.weights + part * change);
    if (corner < 0) return at;
    const int side = (corner + 1) % 3, end = (corner + 2) % 3;
    const uint32_t twin = twins[at.face][side];
    if (twin == kNoIndex) return at;

    const uint32_t face = twin / 3, edge = twin % 3;
    const dvec3 along = glm::normalize(corners[end] - corners[side]);
    const dvec3 out = glm::cross(along, normalOf(t, surface.positions));
    const dvec3 on = glm::cross(along, normalOf(surface.faces[face], surface.positions));
    const dvec3 rest = (1 - part) * step;
    step = glm::dot(rest, along) * along + glm::dot(rest, out) * on;
    SurfacePoint next{.face = face, .weights = dvec3(0)};
    next.weights[edge] = at.weights[end];  // the neighbour traverses the edge the other way
    next.weights[(edge + 1) % 3] = at.weights[side];
    at = {next.face, cleanWeights(next.weights)};
  }
  return at;
}

}  // namespace foreland::terrain
