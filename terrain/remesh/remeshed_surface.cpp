#include "terrain/remesh/remeshed_surface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <utility>

namespace foreland::terrain {

using glm::dvec3;

double finestQuantum(const std::vector<dvec3>& positions) {
  dvec3 low = positions.front(), high = low;
  for (const dvec3& p : positions) low = glm::min(low, p), high = glm::max(high, p);
  const dvec3 reach = glm::max(glm::abs(low), glm::abs(high));
  const double least = std::max({reach.x, reach.y, reach.z}) / kMaxQuanta;
  const double wanted = std::exp2(std::floor(std::log2(glm::length(high - low))) - 20);
  return wanted >= least ? wanted : std::exp2(std::ceil(std::log2(least)));
}

namespace {

// The length of the displacement of each node of the finest level.
std::vector<double> finestDisplacements(const Remeshed& remeshed) {
  const Lattice& lattice = remeshed.lattice;
  std::vector<double> sizes;
  const auto add = [&](uint32_t face, uint32_t i, uint32_t j) {
    const uint32_t di = i & 1, dj = j & 1;
    if (di + dj == 0) return;
    const auto at = [&](uint32_t x, uint32_t y) { return remeshed.positions[lattice.vertex(face, x, y)]; };
    const dvec3 middle = di == 0   ? (at(i, j - 1) + at(i, j + 1)) / 2.0
                         : dj == 0 ? (at(i - 1, j) + at(i + 1, j)) / 2.0
                                   : (at(i - 1, j + 1) + at(i + 1, j - 1)) / 2.0;
    sizes.push_back(glm::distance(at(i, j), middle));
  };
  for (uint32_t face = 0; face < remeshed.base_faces.size(); ++face)
    for (uint32_t j = 0; j <= lattice.side(); ++j)
      for (uint32_t i = 0; i + j <= lattice.side(); ++i) add(face, i, j);
  return sizes;
}

}  // namespace

double defaultQuantum(const Remeshed& remeshed) {
  const double finest = finestQuantum(remeshed.positions);
  std::vector<double> sizes = finestDisplacements(remeshed);
  if (sizes.empty()) return finest;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  const double wanted = *middle > 0 ? std::exp2(std::floor(std::log2(*middle / 16))) : finest;
  return std::clamp(wanted, finest, std::ldexp(finest, 7));
}

Status checkQuantum(const std::vector<dvec3>& positions, double quantum_m) {
  for (const dvec3& p : positions)
    for (int axis = 0; axis < 3; ++axis)
      if (std::fabs(p[axis]) > kMaxQuanta * quantum_m) {
        char text[200];
        std::snprintf(text, sizeof(text),
                      "a coordinate of %g is more than 2^30 steps of %g; move the model (--origin) or choose a coarser "
                      "step (--step)",
                      p[axis], quantum_m);
        return Error{ErrorCode::kLimit, text};
      }
  return {};
}

Result<TrueSurface> toSurface(const Remeshed& remeshed, proto::MeshRule rule, double quantum_m) {
  auto made = proto::MeshTopology::create({rule, static_cast<uint32_t>(std::countr_zero(remeshed.lattice.side())),
                                           static_cast<uint32_t>(remeshed.base_vertices.size()), remeshed.base_faces});
  if (!made.ok()) return made.error();
  const proto::MeshTopology topology = *made;
  const double scale = topology.weightScale();
  return makeSurface(*made, quantum_m, remeshed.base_vertices, [&](proto::NodeId n, const dvec3&) {
    const proto::FacePoint at = topology.facePoint(n);
    if (rule == proto::MeshRule::kQuadrisection)
      return remeshed.positions[remeshed.lattice.vertex(at.face, at.weights[1], at.weights[2])];
    const dvec3 weights = dvec3(at.weights[0], at.weights[1], at.weights[2]) / scale;
    const LatticeCell cell = remeshed.lattice.cellAt(at.face, weights);
    dvec3 drawn(0);
    for (int k = 0; k < 3; ++k) drawn += cell.weights[k] * remeshed.positions[cell.vertices[static_cast<size_t>(k)]];
    return drawn;
  });
}

}  // namespace foreland::terrain
