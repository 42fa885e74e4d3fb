// Spheres that hide one another, as objects of a scene, with the solids inside of them; and by plain means whether one
// is in the way: lines are tried on all triangles, one by one.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <vector>

#include "proto/topology/mesh_triangles.h"
#include "server/section/hierarchy.h"
#include "terrain/remesh/solids/find_solids.h"
#include "terrain/surface/bounds.h"
#include "terrain/surface/shapes.h"
#include "tests/support/surfaces.h"

namespace foreland::test {

using PlainTriangles = std::vector<std::array<glm::dvec3, 3>>;

// The surface's mesh, or its base mesh, in its own frame.
inline PlainTriangles trianglesOf(const terrain::TrueSurface& surface, bool is_full) {
  PlainTriangles out;
  proto::forEachTriangle(
      surface.topology, [&](proto::NodeId) { return is_full; },
      [&](proto::NodeId a, proto::NodeId b, proto::NodeId c) {
        out.push_back({surface.position(a), surface.position(b), surface.position(c)});
      });
  return out;
}

inline bool meets(const glm::dvec3& from, const glm::dvec3& to, const std::array<glm::dvec3, 3>& t) {
  const glm::dvec3 way = to - from, ab = t[1] - t[0], ac = t[2] - t[0], p = glm::cross(way, ac);
  const double volume = glm::dot(ab, p);
  if (volume == 0) return false;
  const glm::dvec3 s = from - t[0], q = glm::cross(s, ab);
  const double u = glm::dot(s, p) / volume, v = glm::dot(way, q) / volume, share = glm::dot(ac, q) / volume;
  return u >= 0 && v >= 0 && u + v <= 1 && share >= 0 && share <= 1;
}

inline double distanceToLine(const glm::dvec3& from, const glm::dvec3& to, const glm::dvec3& p) {
  const glm::dvec3 way = to - from;
  const double share = std::clamp(glm::dot(p - from, way) / glm::dot(way, way), 0.0, 1.0);
  return glm::distance(p, from + share * way);
}

// A cube with its corners on the sphere of radius 1: a box holds it, and a solid fills it, to the millimetre.
inline terrain::TrueSurface makeCube() {
  const std::vector<proto::BaseFace> faces{{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                           {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  auto topology = *proto::MeshTopology::create({proto::MeshRule::kQuadrisection, 1, 8, faces});
  std::vector<glm::dvec3> corners;
  for (uint32_t i = 0; i < 8; ++i)
    corners.push_back((glm::dvec3(i & 1, i >> 1 & 1, i >> 2) * 2.0 - 1.0) / std::sqrt(3.0));
  return *terrain::makeSurface(std::move(topology), 1e-4, corners,
                               [](proto::NodeId, const glm::dvec3& middle) { return middle; });
}

struct HidingSpheres {
  terrain::TrueSurface surface = *terrain::makeSphere(1, {proto::MeshRule::kQuadrisection, 3, 1e-4});
  std::vector<proto::SurfaceRecord> records = terrain::computeBounds(surface, {.threads = 1});
  std::vector<glm::ivec3> moves = terrain::nodeMoves(surface);
  PlainTriangles full = trianglesOf(surface, true), base = trianglesOf(surface, false);

  // What is made of these refers to this.
  server::SceneObjects at(const std::vector<proto::ObjectPlacement>& placements) const {
    server::SceneObjects objects;
    proto::ObjectModel model{surface.topology.shape(), surface.quantum_m, surface.base};
    model.base_moves = terrain::baseMoves(surface);
    objects.set = proto::ObjectSet::create({model}, placements).value();
    objects.nodes.push_back({records, moves, 0});
    server::ModelHull hull{{glm::dvec3(10), glm::dvec3(-10)}, terrain::findSolids(surface).inner.solids};
    for (const terrain::DrawnBox& box : terrain::boxesOfFaces(surface)) {
      hull.box.low = glm::min(hull.box.low, box.low);
      hull.box.high = glm::max(hull.box.high, box.high);
    }
    objects.hulls.push_back(hull);
    for (const auto& placement : placements) objects.balls.push_back({placement.position, 1.8 * placement.scale});
    return objects;
  }

  // Whether an object but `target`, drawn like this, is between an eye and a point.
  bool isBetween(const server::SceneObjects& objects, const PlainTriangles& drawn, size_t target, const glm::dvec3& eye,
                 const glm::dvec3& point) const {
    for (size_t i = 0; i < objects.set.size(); ++i) {
      const proto::ObjectPlacement& placement = objects.set.placement(i);
      if (i == target || distanceToLine(eye, point, placement.position) > 1.1 * placement.scale) continue;
      for (const auto& t : drawn)
        if (meets(eye, point, {placement.toScene(t[0]), placement.toScene(t[1]), placement.toScene(t[2])})) return true;
    }
    return false;
  }
};

}  // namespace foreland::test
