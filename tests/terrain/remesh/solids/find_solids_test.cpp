// Solids inside of surfaces, by plain means: what is drawn is made from its definition (THEORY, equation 2), for random
// weights and for those that push the surface farthest into a solid, and is then asked by rays and by clipped
// triangles.
#include "terrain/remesh/solids/find_solids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>

#include "base/rng.h"
#include "proto/topology/mesh_triangles.h"
#include "terrain/remesh/remeshed_surface.h"
#include "terrain/surface/bounds.h"
#include "terrain/town/buildings.h"
#include "tests/support/models.h"
#include "tests/support/seed.h"
#include "tests/support/surface_file.h"
#include "tests/support/surfaces.h"

namespace foreland::terrain {
namespace {

using glm::dvec3;
using Drawn = std::vector<std::array<dvec3, 3>>;

// What is drawn when each node has the weight that weight(node, displacement) says.
template <class Weight>
Drawn draw(const TrueSurface& surface, const Weight& weight) {
  const proto::MeshTopology& mesh = surface.topology;
  std::vector<dvec3> nodes(mesh.slotCount());
  const auto at = [&](proto::NodeId v) { return mesh.isBase(v) ? surface.position(v) : nodes[mesh.slot(v)]; };
  forEachNode(mesh, [&](proto::NodeId n, proto::Slot slot) {
    const auto [a, b] = mesh.endpoints(n);
    const dvec3 displacement = surface.position(n) - 0.5 * (surface.position(a) + surface.position(b));
    nodes[slot] = 0.5 * (at(a) + at(b)) + weight(n, displacement) * displacement;
  });
  Drawn drawn;
  proto::forEachTriangle(
      mesh, [](proto::NodeId) { return true; },
      [&](proto::NodeId a, proto::NodeId b, proto::NodeId c) {
        drawn.push_back({at(a), at(b), at(c)});
      });
  return drawn;
}

// How often a ray leaves the surface less how often it enters it; for a ray through no edge.
int crossings(const Drawn& drawn, const dvec3& from, const dvec3& direction) {
  int sum = 0;
  for (const auto& [a, b, c] : drawn) {
    const dvec3 ab = b - a, ac = c - a, p = glm::cross(direction, ac);
    const double volume = glm::dot(ab, p);
    if (volume == 0) continue;
    const dvec3 to = from - a, q = glm::cross(to, ab);
    const double u = glm::dot(to, p) / volume, v = glm::dot(direction, q) / volume, t = glm::dot(ac, q) / volume;
    if (u >= 0 && v >= 0 && u + v <= 1 && t > 0) sum += volume < 0 ? 1 : -1;
  }
  return sum;
}

// Whether a part of the triangle lies in all half-spaces: by cutting it at one after the other.
bool enters(const std::array<dvec3, 3>& triangle, const ConvexSolid& solid) {
  for (const SolidPlane& plane : solid.planes())
    if (std::ranges::all_of(triangle, [&](const dvec3& p) { return glm::dot(plane.normal, p) <= plane.offset; }))
      return false;
  std::vector<dvec3> part(triangle.begin(), triangle.end());
  for (const SolidPlane& plane : solid.planes()) {
    std::vector<dvec3> kept;
    for (size_t i = 0; i < part.size(); ++i) {
      const dvec3 &p = part[i], &q = part[(i + 1) % part.size()];
      const double dp = glm::dot(plane.normal, p) - plane.offset, dq = glm::dot(plane.normal, q) - plane.offset;
      if (dp > 0) kept.push_back(p);
      if ((dp > 0) != (dq > 0)) kept.push_back(p + (q - p) * (dp / (dp - dq)));
    }
    part = std::move(kept);
  }
  return !part.empty();
}

dvec3 pointIn(const ConvexSolid& solid, Rng& rng) {
  for (;;) {
    dvec3 p;
    for (int axis = 0; axis < 3; ++axis) p[axis] = rng.uniform(solid.low[axis], solid.high[axis]);
    if (std::ranges::all_of(solid.planes(), [&](const SolidPlane& k) { return glm::dot(k.normal, p) >= k.offset; }))
      return p;
  }
}

size_t entering(const Drawn& drawn, const ConvexSolid& solid) {
  return static_cast<size_t>(std::ranges::count_if(drawn, [&](const auto& t) { return enters(t, solid); }));
}

// Weights that move each vertex as far as they can in a direction, which is that of a solid's plane.
size_t enteringAtWorst(const TrueSurface& surface, const ConvexSolid& solid) {
  size_t worst = 0;
  for (const SolidPlane& plane : solid.planes()) {
    const auto inwards = [&](proto::NodeId, const dvec3& d) { return glm::dot(d, plane.normal) > 0 ? 1.0 : 0.0; };
    worst = std::max(worst, entering(draw(surface, inwards), solid));
  }
  return worst;
}

void expectNeverEntered(const TrueSurface& surface, const ConvexSolid& solid, Rng& rng) {
  const int levels = surface.topology.maxLevel();
  std::vector<Drawn> states;
  for (int level = 0; level <= levels; ++level)
    states.push_back(
        draw(surface, [&](proto::NodeId n, const dvec3&) { return surface.topology.level(n) <= level ? 1.0 : 0.0; }));
  for (int i = 0; i < 3; ++i) {
    states.push_back(draw(surface, [&](proto::NodeId, const dvec3&) { return rng.uniform(); }));
    states.push_back(draw(surface, [&](proto::NodeId, const dvec3&) { return double(rng.below(2)); }));
  }
  for (size_t i = 0; i < states.size(); ++i) {
    EXPECT_EQ(entering(states[i], solid), 0u) << "state " << i;
    for (int k = 0; k < 10; ++k) {
      const dvec3 direction = glm::normalize(test::anyPoint(rng) + dvec3(0.01, 0, 0));
      EXPECT_EQ(crossings(states[i], pointIn(solid, rng), direction), 1) << "state " << i;
    }
  }
  EXPECT_EQ(enteringAtWorst(surface, solid), 0u);
}

TrueSurface remeshed(const Model& model, proto::MeshRule rule) {
  const Original original = makeOriginal(model).value();
  const Remeshed made = remesh(original, {.base_triangles = 120, .levels = 3, .attempts = 1, .threads = 1}).value();
  return toSurface(made, rule, 1e-3).value();
}

Model scaled(Model model, const dvec3& by) {
  for (dvec3& p : model.positions) p *= by;
  return model;
}

struct Named {
  std::string name;
  TrueSurface surface;
};
std::vector<Named> closedSurfaces() {
  std::vector<Named> all;
  for (const auto rule : {proto::MeshRule::kQuadrisection, proto::MeshRule::kBisection}) {
    const std::string by = rule == proto::MeshRule::kBisection ? " by bisection" : "";
    all.push_back({"sphere" + by, *makeSphere(8, {rule, 4, 1e-3})});
    all.push_back({"torus" + by, *makeTorus({12, 5, 8, 6}, {rule, 4, 1e-3})});
    all.push_back({"box" + by, remeshed(scaled(test::makeCube(6), {30, 12, 15}), rule)});
    for (const Building& building : makeBuildings())
      if (building.name == "gable-along" ||
          (rule == proto::MeshRule::kQuadrisection && building.use != BuildingUse::kHouse))
        all.push_back({building.name + by, remeshed(building.model, rule)});
  }
  return all;
}

TEST(FindSolids, LieInsideOfWhateverIsDrawn) {
  const uint64_t seed = test::seedOr(11);
  Rng rng(seed);
  for (const auto& [name, surface] : closedSurfaces()) {
    SCOPED_TRACE(name);
    const SolidsFound found = findSolids(surface);
    EXPECT_EQ(found.why_none, "");
    ASSERT_FALSE(found.inner.solids.empty());
    EXPECT_LE(found.inner.solids.size(), InnerSolids::kMaxSolids);
    EXPECT_GT(found.inner.volume_share, surface.topology.base().faceCount() < 100 ? 0.05 : 0.3);
    EXPECT_LE(found.inner.volume_share, 1);
    for (const ConvexSolid& solid : found.inner.solids) {
      EXPECT_TRUE(isInside(solid, surface));
      expectNeverEntered(surface, solid, rng);
    }
  }
}

// Solids as large as the full mesh alone allows: something that may be drawn enters nearly all of them.
TEST(FindSolids, WithoutRoomForWhatIsDrawnTheyWouldBeEntered) {
  size_t refused = 0, entered = 0, all = 0;
  for (const auto& [name, surface] : closedSurfaces()) {
    SCOPED_TRACE(name);
    for (ConvexSolid solid : findSolids(surface).inner.solids) {
      const FullMesh mesh(surface);
      for (uint32_t k = 0; k < solid.plane_count; ++k) {
        // As far out as no triangle of the full mesh is in the way that no other plane keeps out.
        double needed = -INFINITY;
        for (const auto& t : mesh.triangles()) {
          const auto extent = [&](uint32_t plane) {
            double most = -INFINITY;
            for (const uint32_t v : t)
              most = std::max(most, glm::dot(solid.all_planes[plane].normal, mesh.position(v)));
            return most;
          };
          bool is_out = false;
          for (uint32_t other = 0; other < solid.plane_count && !is_out; ++other)
            is_out = other != k && extent(other) <= solid.all_planes[other].offset;
          if (!is_out) needed = std::max(needed, extent(k));
        }
        solid.all_planes[k].offset = std::min(solid.all_planes[k].offset, needed + 1e-3);
      }
      ++all;
      refused += isInside(solid, surface) ? 0 : 1;
      entered += enteringAtWorst(surface, solid) > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(all, 15u);
  EXPECT_GE(refused, all * 8 / 10);
  EXPECT_GE(entered, all * 6 / 10);
  EXPECT_GE(refused, entered);
}

TEST(FindSolids, SurfacesWithABorderOrPosesHaveNone) {
  const TrueSurface patch = remeshed(scaled(test::makePatch(8), {10, 10, 10}), proto::MeshRule::kQuadrisection);
  EXPECT_TRUE(findSolids(patch).inner.solids.empty());
  EXPECT_EQ(findSolids(patch).why_none, "the surface has a border");
  TrueSurface moving = *makeSphere(8, {proto::MeshRule::kQuadrisection, 3, 1e-3});
  const ConvexSolid solid = findSolids(moving).inner.solids.front();
  EXPECT_TRUE(isInside(solid, moving));
  test::addPoses(moving, 1, 0.1, 0.1, 1);
  EXPECT_TRUE(findSolids(moving).inner.solids.empty());
  EXPECT_FALSE(isInside(solid, moving));
}

TEST(FindSolids, ThinSurfacesHaveNone) {
  const TrueSurface plate = remeshed(scaled(test::makeCube(6), {30, 30, 0.5}), proto::MeshRule::kQuadrisection);
  EXPECT_TRUE(findSolids(plate).inner.solids.empty());
  EXPECT_NE(findSolids(plate).why_none, "");
}

TEST(FindSolids, SurfacesTurnedInsideOutHaveNone) {
  TrueSurface sphere = *makeSphere(8, {proto::MeshRule::kQuadrisection, 3, 1e-3});
  const ConvexSolid solid = findSolids(sphere).inner.solids.front();
  for (glm::ivec3& p : sphere.base) p.x = -p.x;
  for (glm::ivec3& p : sphere.nodes) p.x = -p.x;
  EXPECT_TRUE(findSolids(sphere).inner.solids.empty());
  EXPECT_FALSE(isInside(solid, sphere));
}

TEST(IsInside, RefusesSolidsOutside) {
  const TrueSurface torus = *makeTorus({12, 5, 8, 6}, {proto::MeshRule::kQuadrisection, 3, 1e-3});
  EXPECT_TRUE(isInside(test::cubeAbout({12, 0, 0}, 0.5), torus));
  EXPECT_FALSE(isInside(test::cubeAbout({0, 0, 0}, 0.5), torus)) << "in the hole";
  EXPECT_FALSE(isInside(test::cubeAbout({40, 0, 0}, 0.5), torus)) << "beside it";
  EXPECT_FALSE(isInside(test::cubeAbout({12, 0, 0}, 6), torus)) << "through it";
}

// The bounds of nodes hold what the extents say of every vertex, so largestError is no less than any deviation drawn.
TEST(LargestError, HoldsEveryDeviation) {
  const uint64_t seed = test::seedOr(12);
  Rng rng(seed);
  for (const auto& [name, surface] : closedSurfaces()) {
    SCOPED_TRACE(name);
    const double bound = largestError(surface.topology, computeBounds(surface, {.threads = 1}));
    const Drawn full = draw(surface, [](proto::NodeId, const dvec3&) { return 1.0; });
    double largest = 0;
    for (int i = 0; i < 4; ++i) {
      const double share = i == 0 ? 0 : rng.uniform();
      const Drawn other = draw(surface, [&](proto::NodeId, const dvec3&) {
        return i == 0 ? 0 : rng.uniform() < share ? 1.0 : rng.uniform();
      });
      for (size_t t = 0; t < full.size(); ++t)
        for (size_t k = 0; k < 3; ++k) largest = std::max(largest, glm::distance(full[t][k], other[t][k]));
    }
    EXPECT_LE(largest, bound);
    EXPECT_GT(largest, 0);
  }
}

// Every state that is drawn, and the full mesh, face by face.
TEST(BoxesOfFaces, HoldWhateverIsDrawn) {
  const uint64_t seed = test::seedOr(13);
  Rng rng(seed);
  for (const auto& [name, surface] : closedSurfaces()) {
    SCOPED_TRACE(name);
    const std::vector<DrawnBox> boxes = boxesOfFaces(surface);
    ASSERT_EQ(boxes.size(), surface.topology.base().faceCount());
    for (int i = 0; i < 4; ++i) {
      const Drawn drawn =
          draw(surface, [&](proto::NodeId, const dvec3&) { return i < 2 ? double(i) : double(rng.below(2)); });
      for (size_t t = 0; t < drawn.size(); ++t) {
        const DrawnBox& box = boxes[t / (drawn.size() / boxes.size())];
        for (const dvec3& p : drawn[t])
          for (int axis = 0; axis < 3; ++axis)
            ASSERT_TRUE(p[axis] >= box.low[axis] && p[axis] <= box.high[axis]) << "triangle " << t;
      }
    }
  }
}

TEST(ShapeOf, MeasuresABoxAndItsCorners) {
  const std::vector<SolidPlane> box{{{1, 0, 0}, 1},   {{-1, 0, 0}, -4}, {{0, 1, 0}, -2},
                                    {{0, -1, 0}, -3}, {{0, 0, 1}, 0},   {{0, 0, -1}, -10}};
  const SolidShape shape = shapeOf(box, 100);
  EXPECT_NEAR(shape.volume, 3 * 5 * 10, 1e-6);
  EXPECT_NEAR(shape.thickness, 3, 1e-9);
  EXPECT_NEAR(glm::distance(shape.low, dvec3(1, -2, 0)) + glm::distance(shape.high, dvec3(4, 3, 10)), 0, 1e-9);
  std::vector<SolidPlane> more = box;
  more.push_back({glm::normalize(dvec3(-1, -1, 0)), -7 / std::sqrt(2.0) + std::sqrt(0.5)});
  EXPECT_NEAR(shapeOf(more, 100).volume, 150 - 10 * 0.5, 1e-6);
  more.push_back({{1, 0, 0}, 0.5});
  EXPECT_EQ(makeSolid(more, 100).plane_count, 7u) << "a plane that bounds nothing is left out";
  EXPECT_TRUE(shapeOf(std::span(box).first(5), 100).polygons.empty()) << "without a lid";
  EXPECT_TRUE(shapeOf(box, 5).polygons.empty()) << "beyond what is asked for";
  more.push_back({{-1, 0, 0}, -0.9});
  EXPECT_TRUE(shapeOf(more, 100).polygons.empty()) << "empty";
}

}  // namespace
}  // namespace foreland::terrain
