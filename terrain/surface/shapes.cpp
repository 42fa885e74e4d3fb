#include "terrain/surface/shapes.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <string>
#include <utility>

namespace foreland::terrain {

namespace {

Result<TrueSurface> shape(std::vector<proto::BaseFace> faces, const std::vector<glm::dvec3>& corners,
                          const ShapeDetail& detail, const TruePosition& truePosition) {
  auto topology = proto::MeshTopology::create(
      {detail.rule, detail.halvings, static_cast<uint32_t>(corners.size()), std::move(faces)});
  if (!topology) return topology.error();
  return makeSurface(std::move(*topology), detail.quantum_m, corners, truePosition);
}

}  // namespace

Result<TrueSurface> makeSphere(double radius_m, const ShapeDetail& detail) {
  if (!(radius_m > 0)) return Error{ErrorCode::kInvalidArgument, "sphere: its radius must be positive"};
  const double r = radius_m;
  const std::vector<glm::dvec3> corners{{r, 0, 0}, {-r, 0, 0}, {0, r, 0}, {0, -r, 0}, {0, 0, r}, {0, 0, -r}};
  std::vector<proto::BaseFace> faces{{4, 0, 2}, {4, 2, 1}, {4, 1, 3}, {4, 3, 0},
                                     {5, 2, 0}, {5, 1, 2}, {5, 3, 1}, {5, 0, 3}};
  return shape(std::move(faces), corners, detail,
               [r](proto::NodeId, const glm::dvec3& middle) { return middle * (r / glm::length(middle)); });
}

Result<TrueSurface> makeTorus(const TorusShape& torus, const ShapeDetail& detail) {
  if (!(torus.tube_m > 0 && torus.tube_m < torus.ring_m) || torus.columns < 3 || torus.rows < 3 ||
      uint64_t{torus.columns} * torus.rows > proto::BaseMesh::kMaxVertices)
    return Error{
        ErrorCode::kInvalidArgument,
        "torus: its tube must be thinner than its ring, with 3 to 2^20 squares in rows and columns of 3 or more"};
  std::vector<glm::dvec3> corners;
  std::vector<proto::BaseFace> faces;
  for (uint32_t row = 0; row < torus.rows; ++row)
    for (uint32_t column = 0; column < torus.columns; ++column) {
      const double u = 2 * std::numbers::pi * column / torus.columns, v = 2 * std::numbers::pi * row / torus.rows;
      const double reach = torus.ring_m + torus.tube_m * std::cos(v);
      corners.emplace_back(reach * std::cos(u), reach * std::sin(u), torus.tube_m * std::sin(v));
      const auto at = [&](uint32_t dx, uint32_t dy) {
        return (row + dy) % torus.rows * torus.columns + (column + dx) % torus.columns;
      };
      faces.push_back({at(0, 0), at(1, 0), at(1, 1)});
      faces.push_back({at(0, 0), at(1, 1), at(0, 1)});
    }
  return shape(std::move(faces), corners, detail, [torus](proto::NodeId, const glm::dvec3& middle) {
    const glm::dvec3 flat(middle.x, middle.y, 0), centre = flat * (torus.ring_m / glm::length(flat));
    const glm::dvec3 out = middle - centre;
    return centre + out * (torus.tube_m / glm::length(out));
  });
}

}  // namespace foreland::terrain
