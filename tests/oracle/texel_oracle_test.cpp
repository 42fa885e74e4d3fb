// The parametric bound, seen on textures: the oracle of texels on frames whose errors are known, and its verdict on
// refined surfaces that are drawn with the coordinates of their atlas.
#include "oracle/surface/texel_oracle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <string>

#include "oracle/reference/plain_surface.h"
#include "proto/topology/atlas_layout.h"
#include "terrain/surface/bounds.h"
#include "tests/support/surface_views.h"
#include "tests/support/surfaces.h"

namespace foreland::oracle {
namespace {

using proto::AtlasLayout;
using proto::MeshRule;
using terrain::TrueSurface;
using test::kScreen;
using test::lookAt;

// A square of 4 x 4 texels that faces along x, in two triangles.
std::vector<TexturedTriangle> square() {
  const glm::dvec3 a(0, -1, 1), b(0, -1, -1), c(0, 1, -1), d(0, 1, 1);
  return {{{{{0, 0}, {0, 4}, {4, 4}}}, {a, b, c}}, {{{{0, 0}, {4, 4}, {4, 0}}}, {a, c, d}}};
}

TEST(TexelOracleKnows, WhereATexelIsDrawn) {
  const TexelOracle oracle(square(), 4, 4, false);
  EXPECT_EQ(oracle.texels(), 16u);
  const proto::Pose pose = lookAt({10, 0, 0}, {0, 0, 0});
  auto drawn = square();
  const auto same = oracle.judge(drawn, pose, kScreen);
  EXPECT_LT(same.interior.max_px, 1e-9);
  EXPECT_EQ(same.interior.vertices, 16u);

  for (TexturedTriangle& t : drawn)
    for (glm::dvec2& texel : t.texels) texel.x += 0.5;  // the texture slides, the shape stays
  const auto slid = oracle.judge(drawn, pose, kScreen);
  EXPECT_NEAR(slid.interior.max_px, kScreen.focalPx() * 0.25 / 10, 1e-9);
  EXPECT_NEAR(slid.interior.rms_px, slid.interior.max_px, 1e-9);
  EXPECT_EQ(slid.uncovered, 0u);

  EXPECT_EQ(oracle.judge({&drawn[0], 1}, pose, kScreen).uncovered, 6u);
  EXPECT_EQ(oracle.judge({}, pose, kScreen).uncovered, 16u);
}

TEST(TexelOracleKnows, FrontBackAndSilhouette) {
  auto roof = square();
  roof[1].positions[2].x = -4;  // folded along its diagonal, the upper half away from this eye
  const TexelOracle oracle(roof, 4, 4, true);
  const proto::Pose pose = lookAt({8, -6, -6}, {0, 0, 0});
  const auto verdict = oracle.judge(roof, pose, kScreen);
  EXPECT_EQ(verdict.silhouette.vertices, 4u);  // the diagonal's texels
  EXPECT_EQ(verdict.interior.vertices, 6u);    // of the lower half
}

std::vector<TexturedTriangle> textured(const TrueSurface& surface, const PlainSection& section,
                                       const AtlasLayout& atlas) {
  const double scale = surface.topology.weightScale();
  std::vector<TexturedTriangle> triangles;
  for (const DrawnTriangle& t : drawnTriangles(surface, section)) {
    TexturedTriangle made{{}, t.positions};
    for (size_t k = 0; k < 3; ++k) {
      const double v = t.weights[k][0] / scale, w = t.weights[k][1] / scale;
      made.texels[k] = atlas.coordinates(t.face, {1 - v - w, v, w}) * glm::dvec2(atlas.width(), atlas.height());
    }
    triangles.push_back(made);
  }
  return triangles;
}

TexelOracle oracleOf(const TrueSurface& surface, const AtlasLayout& atlas, bool is_closed) {
  const uint32_t slots = surface.topology.slotCount();
  const PlainSection everything{std::vector<uint8_t>(slots, 1), slots};
  return {textured(surface, everything, atlas), atlas.width(), atlas.height(), is_closed};
}

class Texels : public testing::TestWithParam<MeshRule> {};

// Textures finer and coarser than the full mesh, on every kind of surface: no texel is drawn farther from where it
// belongs than the tolerance there, from anywhere in the region of the view and however the eye has turned in it.
TEST_P(Texels, AreDrawnWithinTheTolerances) {
  size_t left_out = 0;
  for (const test::NamedSurface& named : test::surfaces(GetParam(), 4))
    for (const uint32_t side : {12u, 28u}) {
      SCOPED_TRACE(named.name + ", side " + std::to_string(side));
      const uint32_t faces = named.surface.topology.base().faceCount();
      const AtlasLayout atlas = AtlasLayout::of(faces, side);
      const TexelOracle oracle = oracleOf(named.surface, atlas, named.is_closed);
      EXPECT_EQ(oracle.texels(), uint64_t{faces} * (side + 1) * (side + 2) / 2);
      const auto records = terrain::computeBounds(named.surface, {.threads = 1});
      for (uint64_t seed = 1; seed <= 8; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Rng rng(seed);
        const auto [view, test] = test::anySurfaceView(rng, named.is_closed);
        const auto section = plainRefine(named.surface, records, proto::SurfaceMetric(view, test));
        left_out += named.surface.topology.slotCount() - section.nodes;
        const auto drawn = textured(named.surface, section, atlas);
        for (int i = 0; i < 3; ++i) {
          const auto verdict = oracle.judge(drawn, test::anyPoseOf(view, rng), kScreen, test.nearest_m);
          EXPECT_LE(verdict.silhouette.max_px, view.tau_px);
          EXPECT_LE(verdict.interior.max_px, test.interior_px);
          EXPECT_EQ(verdict.uncovered, 0u);
        }
      }
    }
  EXPECT_GT(left_out, 1000u);
}

INSTANTIATE_TEST_SUITE_P(Rules, Texels, testing::Values(MeshRule::kQuadrisection, MeshRule::kBisection));

// With coordinates that follow the drawn shape instead of its parameters, a texture does slide, and the oracle sees
// it.
TEST(Texels, ASlidingTextureIsSeen) {
  const TrueSurface torus = *terrain::makeTorus({2, 0.8, 4, 3}, {MeshRule::kQuadrisection, 4, 1e-6});
  const AtlasLayout atlas = AtlasLayout::of(torus.topology.base().faceCount(), 16);
  const TexelOracle oracle = oracleOf(torus, atlas, true);
  const PlainSection base{std::vector<uint8_t>(torus.topology.slotCount(), 0), 0};
  auto drawn = textured(torus, base, atlas);
  const proto::Pose pose = lookAt({9, 2, 5}, {0, 0, 0});
  const auto held = oracle.judge(drawn, pose, kScreen);
  for (TexturedTriangle& t : drawn)
    t.texels = {t.texels[0], t.texels[0] + 0.9 * (t.texels[1] - t.texels[0]), t.texels[2]};
  const auto slid = oracle.judge(drawn, pose, kScreen);
  EXPECT_GT(slid.uncovered, 0u);
  EXPECT_GT(slid.interior.max_px + slid.silhouette.max_px, held.interior.max_px);
}

}  // namespace
}  // namespace foreland::oracle
