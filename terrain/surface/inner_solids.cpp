#include "terrain/surface/inner_solids.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <numbers>

#include "base/check.h"

namespace foreland::terrain {

namespace {

using glm::dvec3;

constexpr double kRounding = 1e-6;  // of the largest coordinate; sums of doubles stay far below

// A square about the plane's point next to the origin, which holds all of the plane within `reach` of the origin.
std::vector<dvec3> squareOn(const SolidPlane& plane, double reach) {
  const dvec3& n = plane.normal;
  const dvec3 away = std::fabs(n.z) < 0.7 ? dvec3(0, 0, 1) : dvec3(1, 0, 0);
  const dvec3 u = glm::normalize(glm::cross(n, away)), v = glm::cross(n, u), at = n * plane.offset;
  const double half = 4 * reach;
  return {at - half * u - half * v, at + half * u - half * v, at + half * u + half * v, at - half * u + half * v};
}

void clip(std::vector<dvec3>& polygon, const SolidPlane& plane) {
  std::vector<dvec3> kept;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const dvec3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double dp = glm::dot(plane.normal, p) - plane.offset, dq = glm::dot(plane.normal, q) - plane.offset;
    if (dp >= 0) kept.push_back(p);
    if ((dp > 0 && dq < 0) || (dp < 0 && dq > 0)) kept.push_back(p + (q - p) * (dp / (dp - dq)));
  }
  polygon = std::move(kept);
}

double areaOf(const std::vector<dvec3>& polygon, const dvec3& normal) {
  double area = 0;
  for (size_t i = 2; i < polygon.size(); ++i)
    area += glm::dot(normal, glm::cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]));
  return std::fabs(area) / 2;
}

void measure(SolidShape& shape, std::span<const SolidPlane> planes) {
  std::vector<dvec3> corners;
  for (const auto& polygon : shape.polygons) corners.insert(corners.end(), polygon.begin(), polygon.end());
  shape.low = shape.high = corners.front();
  dvec3 sum(0);
  for (const dvec3& p : corners) shape.low = glm::min(shape.low, p), shape.high = glm::max(shape.high, p), sum += p;
  shape.middle = sum / static_cast<double>(corners.size());
  shape.thickness = INFINITY;
  for (size_t k = 0; k < planes.size(); ++k) {
    if (shape.polygons[k].empty()) continue;
    const dvec3& n = planes[k].normal;
    shape.volume += areaOf(shape.polygons[k], n) * std::max(0.0, glm::dot(n, shape.middle) - planes[k].offset) / 3;
    double extent = 0;
    for (const dvec3& p : corners) extent = std::max(extent, glm::dot(n, p) - planes[k].offset);
    shape.thickness = std::min(shape.thickness, extent);
  }
}

std::vector<DrawnBox> boxesInPose(const TrueSurface& surface) {
  const FullMesh mesh(surface);
  const DrawnExtents extents(surface, mesh);
  std::vector<DrawnBox> boxes(surface.topology.base().faceCount());
  // The full mesh's triangles stand face by face (proto/topology/mesh_triangles.h), as many in each.
  const size_t each = mesh.triangles().size() / boxes.size();
  std::vector<double> most;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      dvec3 direction(0);
      direction[axis] = sign;
      extents.along(direction, most);
      for (size_t face = 0; face < boxes.size(); ++face) {
        double extent = -INFINITY;
        for (const auto& t : mesh.triangles().subspan(face * each, each))
          extent = std::max({extent, most[t[0]], most[t[1]], most[t[2]]});
        (sign < 0 ? boxes[face].low : boxes[face].high)[axis] = sign * (extent + extents.pad());
      }
    }
  return boxes;
}

}  // namespace

SolidShape shapeOf(std::span<const SolidPlane> planes, double reach) {
  SolidShape shape;
  size_t touching = 0;
  for (size_t k = 0; k < planes.size(); ++k) {
    std::vector<dvec3> polygon;
    if (std::fabs(planes[k].offset) <= 2 * reach) polygon = squareOn(planes[k], reach);
    for (size_t other = 0; other < planes.size(); ++other)
      if (other != k) clip(polygon, planes[other]);
    if (polygon.size() < 3) polygon.clear();
    touching += polygon.empty() ? 0 : 1;
    shape.polygons.push_back(std::move(polygon));
  }
  if (touching >= 4) measure(shape, planes);
  const bool is_within = glm::all(glm::lessThanEqual(glm::abs(shape.low), dvec3(reach))) &&
                         glm::all(glm::lessThanEqual(glm::abs(shape.high), dvec3(reach)));
  if (touching < 4 || !is_within || !(shape.volume > 0)) return {};
  return shape;
}

ConvexSolid makeSolid(std::span<const SolidPlane> planes, double reach) {
  CHECK_LE(planes.size(), ConvexSolid::kMaxPlanes);
  const SolidShape shape = shapeOf(planes, reach);
  ConvexSolid solid;
  for (size_t k = 0; k < shape.polygons.size(); ++k)
    if (!shape.polygons[k].empty()) solid.all_planes[solid.plane_count++] = planes[k];
  const dvec3 pad(shape.polygons.empty() ? 0 : kRounding * reach);
  solid.low = shape.low - pad, solid.high = shape.high + pad;
  return solid;
}

DrawnExtents::DrawnExtents(const TrueSurface& surface, const FullMesh& mesh)
    : mesh_(mesh), base_vertices_(surface.base.size()) {
  const proto::MeshTopology& topology = surface.topology;
  forEachNode(topology, [&](proto::NodeId n, proto::Slot) {
    const auto [a, b] = topology.endpoints(n);
    nodes_.push_back({static_cast<uint32_t>(mesh.vertex(n)), static_cast<uint32_t>(mesh.vertex(a)),
                      static_cast<uint32_t>(mesh.vertex(b))});
  });
  std::vector<double> most;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      dvec3 direction(0);
      direction[axis] = sign;
      along(direction, most);
      for (size_t v = 0; v < base_vertices_; ++v) reach_m_ = std::max(reach_m_, most[v]);
      for (const Node& n : nodes_) reach_m_ = std::max(reach_m_, most[n.vertex]);
    }
  reach_m_ = std::max(reach_m_, surface.quantum_m);
  pad_m_ = kRounding * reach_m_;
}

void DrawnExtents::along(const dvec3& direction, std::vector<double>& out) const {
  out.assign(mesh_.vertexCount(), 0);
  for (size_t v = 0; v < base_vertices_; ++v) out[v] = glm::dot(direction, mesh_.position(v));
  for (const Node& n : nodes_) {
    const dvec3 displacement = mesh_.position(n.vertex) - 0.5 * (mesh_.position(n.a) + mesh_.position(n.b));
    out[n.vertex] = 0.5 * (out[n.a] + out[n.b]) + std::max(0.0, glm::dot(direction, displacement));
  }
}

double DrawnExtents::largestDeviation() const {
  std::vector<double> most, squares(mesh_.vertexCount(), 0);
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> farthest(squares.size(), 0);
    for (const double sign : {-1.0, 1.0}) {
      dvec3 direction(0);
      direction[axis] = sign;
      along(direction, most);
      for (const Node& n : nodes_)
        farthest[n.vertex] = std::max(farthest[n.vertex], most[n.vertex] - sign * mesh_.position(n.vertex)[axis]);
    }
    for (const Node& n : nodes_) squares[n.vertex] += farthest[n.vertex] * farthest[n.vertex];
  }
  return std::sqrt(*std::max_element(squares.begin(), squares.end()));
}

std::vector<DrawnBox> boxesOfFaces(const TrueSurface& surface) {
  std::vector<DrawnBox> boxes = boxesInPose(surface);
  for (const SurfacePose& pose : surface.poses) {
    const auto moved = boxesInPose({surface.topology, surface.quantum_m, pose.base, pose.nodes});
    for (size_t face = 0; face < boxes.size(); ++face) {
      boxes[face].low = glm::min(boxes[face].low, moved[face].low);
      boxes[face].high = glm::max(boxes[face].high, moved[face].high);
    }
  }
  return boxes;
}

// The sum of the triangles' solid angles (Van Oosterom and Strackee, "The solid angle of a plane triangle", 1983).
double windingNumber(const FullMesh& mesh, const dvec3& point) {
  double angles = 0;
  for (const auto& t : mesh.triangles()) {
    const dvec3 a = mesh.position(t[0]) - point, b = mesh.position(t[1]) - point, c = mesh.position(t[2]) - point;
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    const double across = glm::dot(a, glm::cross(b, c));
    const double along = la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb;
    angles += 2 * std::atan2(across, along);
  }
  return angles / (4 * std::numbers::pi);
}

bool isInside(const ConvexSolid& solid, const TrueSurface& surface) {
  if (!surface.topology.base().isClosed() || !surface.poses.empty() || solid.plane_count == 0) return false;
  const FullMesh mesh(surface);
  const DrawnExtents extents(surface, mesh);
  std::vector<std::vector<double>> most(solid.plane_count);
  for (size_t k = 0; k < most.size(); ++k) extents.along(solid.all_planes[k].normal, most[k]);
  const auto isApart = [&](const std::array<uint32_t, 3>& t) {
    for (size_t k = 0; k < most.size(); ++k)
      if (std::max({most[k][t[0]], most[k][t[1]], most[k][t[2]]}) + extents.pad() <= solid.all_planes[k].offset)
        return true;
    return false;
  };
  if (!std::ranges::all_of(mesh.triangles(), isApart)) return false;
  const SolidShape shape = shapeOf(solid.planes(), extents.reach());
  return !shape.polygons.empty() && std::fabs(windingNumber(mesh, shape.middle) - 1) < 1e-3;
}

double largestError(const proto::MeshTopology& topology, std::span<const proto::SurfaceRecord> records) {
  double largest = 0;
  for (proto::Slot slot = topology.levelOffset(1); slot < topology.levelOffset(2); ++slot)
    largest = std::max<double>({largest, records[slot].error_along.metres(), records[slot].error_across.metres()});
  return largest;
}

}  // namespace foreland::terrain
