// From remesh to surface, by both rules.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "terrain/compare/deviation.h"
#include "terrain/remesh/paint/point_location.h"
#include "terrain/remesh/remeshed_surface.h"
#include "terrain/surface/full_mesh.h"
#include "tests/support/models.h"

namespace foreland::terrain {
namespace {

using glm::dvec3;

struct Torus {
  Original original = makeOriginal(test::makeTorus(40, 20)).value();
  Remeshed remeshed = remesh(original, {.base_triangles = 80, .levels = 3, .attempts = 1}).value();
};

TEST(SurfaceOf, MovesPositionsByLessThanAQuantum) {
  const Torus torus;
  const double step = defaultQuantum(torus.remeshed);
  const auto surface = toSurface(torus.remeshed, proto::MeshRule::kQuadrisection, step);
  ASSERT_TRUE(surface.ok());
  const Lattice& lattice = torus.remeshed.lattice;
  for (uint32_t face = 0; face < torus.remeshed.base_faces.size(); ++face)
    for (int32_t j = 0; j <= 8; ++j)
      for (int32_t i = 0; i + j <= 8; ++i) {
        const dvec3& wanted =
            torus.remeshed.positions[lattice.vertex(face, static_cast<uint32_t>(i), static_cast<uint32_t>(j))];
        const proto::NodeId name = surface->topology.quad().name({face, i, j});
        EXPECT_LE(glm::distance(surface->position(name), wanted), 0.867 * step);
      }
}

TEST(DefaultQuantum, IsASixteenthOfWhatTheFinestLevelAddsOrLess) {
  const Torus torus;
  const auto surface = toSurface(torus.remeshed, proto::MeshRule::kQuadrisection, 1e-8);
  ASSERT_TRUE(surface.ok());
  const proto::MeshTopology& mesh = surface->topology;
  std::vector<double> sizes;
  forEachNode(mesh, [&](proto::NodeId n, proto::Slot) {
    if (mesh.level(n) != mesh.maxLevel()) return;
    const auto [a, b] = mesh.endpoints(n);
    sizes.push_back(glm::distance(surface->position(n), 0.5 * (surface->position(a) + surface->position(b))));
  });
  std::sort(sizes.begin(), sizes.end());
  const double step = defaultQuantum(torus.remeshed);
  EXPECT_EQ(std::exp2(std::round(std::log2(step))), step);
  // The lattice has vertices of base edges twice, so its median is not quite the nodes'.
  EXPECT_LE(step, sizes[sizes.size() * 6 / 10] / 16);
  EXPECT_GE(step, sizes[sizes.size() * 4 / 10] / 32);
}

TEST(DefaultQuantum, OfAFlatMeshIsTheFinest) {
  Torus torus;
  for (dvec3& p : torus.remeshed.positions) p = {1, 2, 3};
  torus.remeshed.positions.front() = {1, 2, 4};
  EXPECT_EQ(finestQuantum(torus.remeshed.positions), std::exp2(-20));
  EXPECT_EQ(defaultQuantum(torus.remeshed), finestQuantum(torus.remeshed.positions));
}

TEST(SurfaceOf, BothRulesLieNextToTheOriginalAndDoNotFold) {
  const Torus torus;
  const ClosestPoint closest({torus.original.positions, torus.original.faces});
  for (const proto::MeshRule rule : {proto::MeshRule::kQuadrisection, proto::MeshRule::kBisection}) {
    const auto surface = toSurface(torus.remeshed, rule, 1e-7);
    ASSERT_TRUE(surface.ok());
    const FullMesh full(*surface);
    std::vector<dvec3> positions;
    for (size_t v = 0; v < surface->topology.baseVertexCount() + size_t{surface->topology.slotCount()}; ++v)
      positions.push_back(full.position(v));
    forEachNode(surface->topology,
                [&](proto::NodeId n, proto::Slot) { EXPECT_LT(closest.find(surface->position(n)).distance, 0.02); });
    EXPECT_TRUE(findFlipped({positions, full.triangles()}, closest, 2).empty());
    EXPECT_LT(largestDistance({positions, full.triangles()}, closest, 1e-3, 2), 0.02);
  }
}

TEST(SurfaceOf, QuantaThatAreTooFineAreRefused) {
  const Torus torus;
  EXPECT_FALSE(toSurface(torus.remeshed, proto::MeshRule::kQuadrisection, 1e-12).ok());
}

TEST(PlaceUnder, MeetsLatticeVerticesAndLiesNextToTheFullMesh) {
  const Torus torus;
  const auto& [original, remeshed] = torus;
  for (uint32_t face = 0; face < remeshed.base_faces.size(); ++face)
    for (int k = 0; k < 200; ++k) {
      const double u = std::fmod(k * 0.618, 1), v = (1 - u) * k / 200.0;
      const LatticeCell cell = remeshed.lattice.cellAt(face, {1 - u - v, u, v});
      dvec3 drawn(0);
      for (int i = 0; i < 3; ++i) drawn += cell.weights[i] * remeshed.positions[cell.vertices[static_cast<size_t>(i)]];
      const dvec3 under =
          positionOf(locateOnOriginal(original, remeshed, face, {1 - u - v, u, v}), original.positions, original.faces);
      EXPECT_LT(glm::distance(drawn, under), 0.03);
    }
}

}  // namespace
}  // namespace foreland::terrain
