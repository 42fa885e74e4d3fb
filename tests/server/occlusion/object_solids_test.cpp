// What an object is called hidden behind is in the way indeed: each vertex of the hidden object, from eyes displaced
// as far as they may be, however the objects in front of it are drawn. Lines are tried on all triangles, one by one.
#include "server/occlusion/objects/object_solids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <vector>

#include "base/rng.h"
#include "proto/topology/mesh_triangles.h"
#include "server/occlusion/objects/viewer_objects.h"
#include "terrain/remesh/solids/find_solids.h"
#include "terrain/surface/bounds.h"
#include "terrain/surface/shapes.h"
#include "tests/support/seed.h"
#include "tests/support/surfaces.h"

namespace foreland::server {
namespace {

using glm::dvec3;
using Triangles = std::vector<std::array<dvec3, 3>>;

// The surface's mesh, or its base mesh, in its own frame.
Triangles trianglesOf(const terrain::TrueSurface& surface, bool is_full) {
  Triangles out;
  proto::forEachTriangle(
      surface.topology, [&](proto::NodeId) { return is_full; },
      [&](proto::NodeId a, proto::NodeId b, proto::NodeId c) {
        out.push_back({surface.position(a), surface.position(b), surface.position(c)});
      });
  return out;
}

bool meets(const dvec3& from, const dvec3& to, const std::array<dvec3, 3>& t) {
  const dvec3 way = to - from, ab = t[1] - t[0], ac = t[2] - t[0], p = glm::cross(way, ac);
  const double volume = glm::dot(ab, p);
  if (volume == 0) return false;
  const dvec3 s = from - t[0], q = glm::cross(s, ab);
  const double u = glm::dot(s, p) / volume, v = glm::dot(way, q) / volume, share = glm::dot(ac, q) / volume;
  return u >= 0 && v >= 0 && u + v <= 1 && share >= 0 && share <= 1;
}

double distanceToLine(const dvec3& from, const dvec3& to, const dvec3& p) {
  const dvec3 way = to - from;
  const double share = std::clamp(glm::dot(p - from, way) / glm::dot(way, way), 0.0, 1.0);
  return glm::distance(p, from + share * way);
}

// Spheres that stand about in a square, as objects of a scene.
struct Field {
  static constexpr double kSide_m = 400;
  terrain::TrueSurface surface = *terrain::makeSphere(1, {proto::MeshRule::kQuadrisection, 3, 1e-4});
  std::vector<proto::SurfaceRecord> records = terrain::computeBounds(surface, {.threads = 1});
  std::vector<glm::ivec3> moves = terrain::nodeMoves(surface);
  SceneObjects objects;
  std::shared_ptr<const ObjectSolids> solids;

  Field(size_t count, Rng& rng) {
    std::vector<proto::ObjectPlacement> placements;
    for (size_t i = 0; i < count; ++i)
      placements.push_back({0,
                            {rng.uniform(0, kSide_m), rng.uniform(0, kSide_m), rng.uniform(-4, 4)},
                            glm::angleAxis(rng.uniform(0, 6), glm::normalize(dvec3(rng.uniform(), 1, rng.uniform()))),
                            i % 4 == 0 ? rng.uniform(15, 25) : rng.uniform(3, 8)});
    proto::ObjectModel model{surface.topology.shape(), surface.quantum_m, surface.base};
    model.base_moves = terrain::baseMoves(surface);
    objects.set = proto::ObjectSet::create({model}, placements).value();
    objects.nodes.push_back({records, moves, 0});
    ModelHull hull{{dvec3(10), dvec3(-10)}, terrain::findSolids(surface).inner.solids};
    for (const terrain::DrawnBox& box : terrain::boxesOfFaces(surface)) {
      hull.box.low = glm::min(hull.box.low, box.low);
      hull.box.high = glm::max(hull.box.high, box.high);
    }
    objects.hulls.push_back(hull);
    for (const auto& placement : placements) objects.balls.push_back({placement.position, 1.8 * placement.scale});
    solids = ObjectSolids::create(objects).value();
  }

  // Whether some other object, drawn like this, is in the way.
  bool isBlocked(size_t target, const Triangles& drawn, const dvec3& eye, const dvec3& point) const {
    for (size_t i = 0; i < objects.set.size(); ++i) {
      const proto::ObjectPlacement& placement = objects.set.placement(i);
      if (i == target || distanceToLine(eye, point, placement.position) > 1.1 * placement.scale) continue;
      for (const auto& t : drawn)
        if (meets(eye, point, {placement.toScene(t[0]), placement.toScene(t[1]), placement.toScene(t[2])})) return true;
    }
    return false;
  }
};

struct Attacked {
  uint64_t hidden = 0, lines = 0, seen = 0;
};

// Proofs are for `share` of the radius of the eyes that attack.
Attacked attack(const Field& field, double share, Rng& rng) {
  const std::array drawn{trianglesOf(field.surface, true), trianglesOf(field.surface, false)};
  Attacked attacked;
  for (int path = 0; path < 12; ++path) {
    const EyeCapsule eyes{{rng.uniform(0, Field::kSide_m), -20, rng.uniform(-3, 8)},
                          {rng.uniform(-3, 3), rng.uniform(-2, 2), rng.uniform(-1, 1)},
                          rng.uniform(0.5, 2)};
    const EyeCapsule proved{eyes.eye, eyes.way, share * eyes.radius_m};
    for (size_t object = 0; object < field.objects.set.size(); ++object) {
      uint32_t hint = ObjectSolids::kNone;
      uint64_t queries = 0;
      if (!hideFrom(*field.solids, proved, field.solids->cornersOf(object), 0, hint, queries)) continue;
      ++attacked.hidden;
      for (const auto& t : drawn[0]) {
        const dvec3 point = field.objects.set.placement(object).toScene(t[0]);
        for (const double along : {0.0, 0.5, 1.0}) {
          dvec3 off{rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1)};
          off *= eyes.radius_m / std::max(1e-6, glm::length(off));
          const dvec3 eye = eyes.eye + along * eyes.way + off;
          ++attacked.lines;
          for (const Triangles& state : drawn) attacked.seen += field.isBlocked(object, state, eye, point) ? 0 : 1;
        }
      }
    }
  }
  return attacked;
}

TEST(ObjectSolids, HideFromAllEyesWhateverIsDrawn) {
  Rng rng(test::randomSeed());
  const Field field(60, rng);
  ASSERT_GT(field.solids->solidCount(), 0u);
  const Attacked attacked = attack(field, 1, rng);
  EXPECT_GT(attacked.hidden, 10u);
  EXPECT_EQ(attacked.seen, 0u) << "of " << attacked.lines;
}

// That the attack finds wrong proofs.
TEST(ObjectSolids, AttackFindsProofsForFewerEyes) {
  Rng rng(test::randomSeed());
  const Field field(60, rng);
  EXPECT_GT(attack(field, 0, rng).seen, 0u);
}

TEST(ObjectSolids, HideNothingFromWithinTheirObject) {
  Rng rng(test::randomSeed());
  const Field field(2, rng);
  const dvec3 inside = field.objects.set.placement(0).position;
  uint32_t hint = 0;
  uint64_t queries = 0;
  EXPECT_FALSE(hideFrom(*field.solids, {inside, {}, 0.1}, field.solids->cornersOf(1), 0, hint, queries));
}

// Of ground that carries it, the box holds the object wherever that is.
TEST(ObjectSolids, BoxesHoldTheObjects) {
  Rng rng(test::randomSeed());
  const Field field(20, rng);
  const Triangles drawn = trianglesOf(field.surface, true);
  for (size_t i = 0; i < 20; ++i)
    for (const auto& t : drawn)
      EXPECT_LE(glm::distance(field.objects.set.placement(i).toScene(t[0]), field.solids->middleOf(i)),
                field.solids->radiusOf(i) + 1e-9);
}

}  // namespace
}  // namespace foreland::server
