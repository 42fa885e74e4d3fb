// Surfaces chosen by property: smooth and closed, curved both ways, rough, with a border, with texture that slides
// along (nodes far from the middle of their edges), flat in places, and with zero-area triangles.
#pragma once

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <string>
#include <utility>
#include <vector>

#include "base/rng.h"
#include "terrain/surface/shapes.h"
#include "terrain/surface/surface.h"
#include "tests/support/base_meshes.h"

namespace foreland::test {

struct NamedSurface {
  std::string name;
  terrain::TrueSurface surface;
  bool is_closed = true;
};

// A random point in the cube of half side 1. Coordinates are drawn one by one, since the order of evaluation of
// arguments depends on the compiler.
inline glm::dvec3 anyPoint(Rng& rng) {
  const double z = rng.uniform(-1, 1), y = rng.uniform(-1, 1), x = rng.uniform(-1, 1);
  return {x, y, z};
}

// The base's vertices lie at random points of a sphere; every node is displaced by up to `rough` of its edge's length
// in a random direction.
inline terrain::TrueSurface roughSurface(const NamedBase& base, proto::MeshRule rule, uint32_t halvings, double rough,
                                         uint64_t seed) {
  Rng rng(seed);
  auto topology = *proto::MeshTopology::create({rule, halvings, base.vertices, base.faces});
  std::vector<glm::dvec3> corners;
  for (uint32_t v = 0; v < base.vertices; ++v)
    corners.push_back(glm::normalize(anyPoint(rng) + glm::dvec3(0.01, 0, 0)));
  const proto::MeshTopology mesh = topology;
  const auto position = [&](proto::NodeId v, const glm::dvec3& middle) {
    return middle +
           anyPoint(rng) * (rough * std::exp2(-mesh.level(v) * (rule == proto::MeshRule::kBisection ? 0.5 : 1.0)));
  };
  return *terrain::makeSurface(std::move(topology), 1e-6, corners, position);
}

// Adds poses: the surface stretched and sheared by up to `far` of its size, each vertex apart from that by up to
// `rough` of its edge's length.
inline void addPoses(terrain::TrueSurface& surface, size_t count, double far, double rough, uint64_t seed) {
  Rng rng(seed);
  const proto::MeshTopology& mesh = surface.topology;
  for (size_t pose = 0; pose < count; ++pose) {
    const glm::dvec3 x = anyPoint(rng), y = anyPoint(rng), z = anyPoint(rng), to = anyPoint(rng);
    const auto moved = [&](proto::NodeId v) {
      const glm::dvec3 p = surface.position(v);
      const double edge = std::exp2(-mesh.level(v) * (mesh.rule() == proto::MeshRule::kBisection ? 0.5 : 1.0));
      const glm::dvec3 off = far * (x * p.x + y * p.y + z * p.z + to) + rough * edge * anyPoint(rng);
      return glm::ivec3(glm::round((p + off) / surface.quantum_m));
    };
    terrain::SurfacePose made{{}, std::vector<glm::ivec3>(surface.nodes.size())};
    for (uint32_t v = 0; v < mesh.baseVertexCount(); ++v) made.base.push_back(moved(proto::baseVertexId(v)));
    terrain::forEachNode(mesh, [&](proto::NodeId n, proto::Slot slot) { made.nodes[slot] = moved(n); });
    surface.poses.push_back(std::move(made));
  }
}

inline std::vector<NamedSurface> surfaces(proto::MeshRule rule, uint32_t halvings) {
  const auto& bases = baseMeshes();
  const auto base = [&](const std::string& name) {
    for (const NamedBase& b : bases)
      if (b.name == name) return b;
    return bases.front();
  };
  std::vector<NamedSurface> all;
  all.push_back({"Sphere", *terrain::makeSphere(1, {rule, halvings, 1e-6})});
  all.push_back({"Torus", *terrain::makeTorus({2, 0.8, 4, 3}, {rule, halvings, 1e-6})});
  all.push_back({"Rough", roughSurface(base("ShuffledOctahedron"), rule, halvings, 0.2, 1)});
  all.push_back({"Crumpled", roughSurface(base("ShuffledFanOf7"), rule, halvings, 1.0, 2), false});
  all.push_back({"Flat", roughSurface(base("Triangle"), rule, halvings, 0.0, 3), false});
  // Flat, but for the base's corners, which lie below: errors along the normal alone, as large at supports' rims as
  // amid.
  auto flat = *proto::MeshTopology::create({rule, halvings, 3, {{0, 1, 2}}});
  all.push_back({"Plateau",
                 *terrain::makeSurface(std::move(flat), 1e-6, {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}},
                                       [](proto::NodeId, const glm::dvec3& m) { return glm::dvec3(m.x, m.y, 0.05); }),
                 false});
  // All nodes at one point: triangles without area or normal.
  auto topology = *proto::MeshTopology::create({rule, halvings, 3, {{0, 1, 2}}});
  all.push_back({"Collapsed",
                 *terrain::makeSurface(std::move(topology), 1e-6, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                                       [](proto::NodeId, const glm::dvec3&) { return glm::dvec3(0.2, 0.2, 0.1); }),
                 false});
  return all;
}

}  // namespace foreland::test
