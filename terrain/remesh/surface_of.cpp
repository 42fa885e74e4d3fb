#include "terrain/remesh/surface_of.h"

#include <bit>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <utility>

namespace foreland::terrain {

using glm::dvec3;

double defaultStep(const std::vector<dvec3>& positions) {
  dvec3 low = positions.front(), high = low;
  for (const dvec3& p : positions) low = glm::min(low, p), high = glm::max(high, p);
  return std::exp2(std::floor(std::log2(glm::length(high - low))) - 20);
}

Status checkStep(const std::vector<dvec3>& positions, double step_m) {
  for (const dvec3& p : positions)
    for (int axis = 0; axis < 3; ++axis)
      if (std::fabs(p[axis]) > kMaxSteps * step_m) {
        char text[120];
        std::snprintf(text, sizeof(text),
                      "a coordinate of %g is more than 2^30 steps of %g; move the model or choose a coarser step",
                      p[axis], step_m);
        return Error{ErrorCode::kLimit, text};
      }
  return {};
}

Result<TrueSurface> surfaceOf(const Remeshed& remeshed, proto::MeshRule rule, double step_m) {
  auto made = proto::MeshTopology::create({rule, static_cast<uint32_t>(std::countr_zero(remeshed.lattice.side())),
                                           static_cast<uint32_t>(remeshed.base_vertices.size()), remeshed.base_faces});
  if (!made.ok()) return made.error();
  const proto::MeshTopology topology = *made;
  const double scale = topology.placeScale();
  return makeSurface(*made, step_m, remeshed.base_vertices, [&](proto::NodeId n, const dvec3&) {
    const proto::MeshPlace place = topology.place(n);
    if (rule == proto::MeshRule::kQuadrisection)
      return remeshed.positions[remeshed.lattice.vertex(place.face, place.weights[1], place.weights[2])];
    const dvec3 weights = dvec3(place.weights[0], place.weights[1], place.weights[2]) / scale;
    const LatticeCell cell = remeshed.lattice.cellAt(place.face, weights);
    dvec3 drawn(0);
    for (int k = 0; k < 3; ++k) drawn += cell.weights[k] * remeshed.positions[cell.vertices[static_cast<size_t>(k)]];
    return drawn;
  });
}

}  // namespace foreland::terrain
