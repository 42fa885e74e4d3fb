// The real models, held to the bars: at most 0.3 % of the diagonal off with four levels over about 200 triangles, no
// fold. Under a sanitizer, which is ten times slower, one attempt of two levels shows that memory is in order.
#include <gtest/gtest.h>

#include <algorithm>

#include "base/sanitized.h"
#include "terrain/compare/deviation.h"
#include "terrain/model/read_model.h"
#include "terrain/remesh/remesh.h"
#include "tests/support/data.h"

namespace foreland::terrain {
namespace {

constexpr bool kIsSanitized = FORELAND_SANITIZED;

void expectWithinBars(const std::filesystem::path& path) {
  const auto model = readModel(path);
  ASSERT_TRUE(model.ok()) << model.error().message;
  const auto surface = makeOriginal(*model);
  ASSERT_TRUE(surface.ok()) << surface.error().message;
  const RemeshOptions defaults;
  const auto made = remesh(
      *surface, {.levels = kIsSanitized ? 2 : defaults.levels, .attempts = kIsSanitized ? 1 : defaults.attempts});
  ASSERT_TRUE(made.ok());
  EXPECT_NEAR(static_cast<double>(made->base_faces.size()), 200, 2);
  const auto triangles = made->lattice.triangles();
  EXPECT_EQ(triangles.size(), made->base_faces.size() * (kIsSanitized ? 16 : 256));
  if (kIsSanitized) return;

  glm::dvec3 low = surface->positions.front(), high = low;
  for (const glm::dvec3& p : surface->positions) low = glm::min(low, p), high = glm::max(high, p);
  const double diagonal = glm::length(high - low);
  const MeshView of{surface->positions, surface->faces}, by{made->positions, triangles};
  const ClosestPoint to_original(of), to_remesh(by);
  const double tolerance = 5e-4 * diagonal;
  EXPECT_LE(largestDistance(by, to_original, tolerance, 0) + tolerance, 0.003 * diagonal);
  EXPECT_LE(largestDistance(of, to_remesh, tolerance, 0) + tolerance, 0.003 * diagonal);
  EXPECT_TRUE(findFlipped(by, to_original, 0).empty());
}

TEST(RemeshRealData, SpotIsWithinTheBars) {
  FORELAND_DATA_OR_SKIP(path, "models/spot.obj");
  expectWithinBars(path);
}

TEST(RemeshRealData, StandingBlobIsWithinTheBars) {
  FORELAND_DATA_OR_SKIP(path, "models/standingblob.ply");
  expectWithinBars(path);
}

// Quadrangles, triangles and borders, and two vertices where parts touch only because of welding.
TEST(RemeshRealData, SuzanneKeepsHerTopology) {
  FORELAND_DATA_OR_SKIP(path, "models/suzanne.obj");
  const auto model = readModel(path);
  ASSERT_TRUE(model.ok());
  const auto surface = makeOriginal(*model);
  ASSERT_TRUE(surface.ok()) << surface.error().message;
  EXPECT_EQ(surface->positions.size(), 507u);
  EXPECT_EQ(surface->faces.size(), 968u);
  const auto made = remesh(*surface, {.base_triangles = 400, .levels = kIsSanitized ? 2 : 4, .attempts = 1});
  ASSERT_TRUE(made.ok());
  uint32_t border = 0;
  for (uint32_t e = 0; e < made->lattice.edgeCount(); ++e) border += made->lattice.edge(e).is_border;
  EXPECT_GT(border, 0u);
  EXPECT_LE(made->base_faces.size(), 400u);
}

}  // namespace
}  // namespace foreland::terrain
