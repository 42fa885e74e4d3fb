// The judge of scenes that are fine in places only agrees with the one that reads every position of the lattice; it
// finds nothing wrong with what is refined to the last vertex, and what was done to that.
#include "oracle/sparse_oracle.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "apps/exact_sections.h"
#include "oracle/scene_truth.h"
#include "proto/space/frame_grid.h"
#include "tests/support/sparse_scene.h"

namespace foreland::oracle {
namespace {

using proto::FrameKind;
using proto::NodeId;

constexpr uint32_t kWidth = 321, kHeight = 225;
const proto::Lens kLens{.vertical_fov_rad = 1, .width_px = 900, .height_px = 900};

std::shared_ptr<const terrain::Scene> sparseHills(FrameKind kind) {
  return test::makeSparseScene(kWidth, kHeight, test::hills(11), kind, 4, {{90, 80, 50}, {220, 150, 20}});
}

// Sees all of the ground from above, or nearly so.
proto::Pose above(const terrain::Scene& scene, double extent) {
  const proto::FrameGrid grid(scene.frame(), scene.grid().maxX(), scene.grid().maxY());
  const auto at = [&](uint32_t x, uint32_t y) { return grid.position(NodeId::at(x, y), 0); };
  const glm::dvec3 middle = at(kWidth / 2, kHeight / 2);
  const double width_m = glm::distance(at(0, kHeight / 2), at(kWidth - 1, kHeight / 2));
  return {middle + glm::dvec3(0, 0, extent * width_m), proto::lookAlong({0.02, 0.01, -1}, {0, 1, 0})};
}

std::shared_ptr<const client::KeyframeMesh> refinedTo(const std::shared_ptr<const terrain::Scene>& scene, double tau_px,
                                                      const proto::Pose& pose) {
  return apps::exactSectionsOf(scene)()({.pose = pose, .lens = kLens, .tau_px = tau_px});
}

class SparseOracle : public testing::TestWithParam<FrameKind> {};

TEST_P(SparseOracle, FindsNothingWrongWithWhatIsRefinedToTheLastVertex) {
  const auto scene = sparseHills(GetParam());
  Patchwork oracle = sparseOracle(scene);
  for (const double extent : {1.0, 1.5, 2.0}) {
    const proto::Pose pose = above(*scene, extent);
    const Deviation found = oracle.error(*refinedTo(scene, 1e-5, pose), 0.5, pose, kLens);
    EXPECT_LT(found.max_px, 1e-3) << extent;
    EXPECT_EQ(found.uncovered, 0u) << extent;
    EXPECT_GT(found.samples, 300u) << extent;
  }
}

// In metres the vertices are what matters: between them it is less.
TEST_P(SparseOracle, MeasuresAsMuchAsAnOracleOfEveryPosition) {
  const auto scene = sparseHills(GetParam());
  Patchwork sparse = sparseOracle(scene);
  Oracle whole(truthOf(scene));
  const proto::Pose pose = above(*scene, 2);
  for (const double tau_px : {0.5, 2.0, 8.0}) {
    const auto mesh = refinedTo(scene, tau_px, pose);
    const DrawnShare drawn{.mesh = mesh.get()};
    const Deviation expected = whole.error({&drawn, 1}, pose, kLens), found = sparse.error(*mesh, 0, pose, kLens);
    ASSERT_EQ(expected.samples, uint64_t{kWidth} * kHeight);
    EXPECT_GT(found.max_m, scene->frame().height_quantum_m);
    EXPECT_NEAR(found.max_m, expected.max_m, scene->frame().height_quantum_m) << tau_px;  // heights between are rounded
    EXPECT_LE(found.max_px, 1.001 * tau_px);
    EXPECT_EQ(found.uncovered, 0u);
  }
}

TEST_P(SparseOracle, ComparesDrawnSurfacesAsAnOracleOfEveryPosition) {
  const auto scene = sparseHills(GetParam());
  Patchwork sparse = sparseOracle(scene);
  Oracle whole(truthOf(scene));
  const proto::Pose pose = above(*scene, 2);
  const auto coarse = refinedTo(scene, 6, pose), fine = refinedTo(scene, 1, pose);
  const DrawnShare shares[] = {{.mesh = coarse.get(), .share = 0.25}, {.mesh = fine.get(), .share = 0.75}};
  const DrawnShare other{.mesh = fine.get()};
  const Deviation expected = whole.difference(shares, {&other, 1}, pose, kLens),
                  found = sparse.difference(shares, {&other, 1}, pose, kLens);
  EXPECT_GT(expected.max_m, 0);
  EXPECT_NEAR(found.max_m, expected.max_m, 1e-3 * expected.max_m);
}

TEST_P(SparseOracle, MeasuresALiftedVertexOfTheFinestLevel) {
  const auto scene = sparseHills(GetParam());
  const proto::Pose pose = above(*scene, 2);
  client::KeyframeMesh mesh = *refinedTo(scene, 1e-5, pose);
  const NodeId deep = NodeId::at(91, 82);
  size_t v = 0;
  while (v < mesh.parameters.size() && mesh.parameters[v] != glm::vec2(deep.x(), deep.y())) ++v;
  ASSERT_LT(v, mesh.parameters.size());
  mesh.to_positions[v].z += 25;
  Patchwork oracle = sparseOracle(scene);
  const Deviation found = oracle.twin().error(mesh, 1, pose, kLens);
  EXPECT_NEAR(found.max_m, 25, 0.1);
  EXPECT_EQ(found.worst_sample, glm::uvec2(deep.x(), deep.y()));
  EXPECT_NEAR(oracle.error(mesh, 0.5, pose, kLens).max_m, 12.5, 0.1);
  // A hole where the ground is fine.
  for (size_t t = 0; t < mesh.indices.size(); t += 3)
    if (glm::distance(mesh.parameters[mesh.indices[t]], glm::vec2(deep.x(), deep.y())) < 3)
      mesh.indices[t + 1] = mesh.indices[t];
  EXPECT_GE(oracle.error(mesh, 0, pose, kLens).uncovered, 1u);
}

// Nothing is drawn, so each vertex is uncovered, and those between patches at most twice.
TEST_P(SparseOracle, LooksAtEveryVertexThatIsThere) {
  const auto scene = sparseHills(GetParam());
  const proto::GridTopology& grid = scene->grid();
  uint64_t there = 0, on_borders = 0;
  scene->pages().forEachPage([&](proto::Slot first, uint64_t) {
    for (proto::Slot slot = first; slot < first + proto::kPageSlots; ++slot) {
      const NodeId n = grid.node(slot);
      if (n == NodeId{} || n.x() >= kWidth || n.y() >= kHeight) continue;
      ++there;
      for (uint32_t step = 1; step < 16; step *= 2)
        on_borders += n.x() % (1024 * step) == 0 || n.y() % (1024 * step) == 0;
    }
  });
  for (uint32_t y = 0; y < kHeight; y += 16)
    for (uint32_t x = 0; x < kWidth; x += 16) there += grid.level(NodeId::at(x, y)) == 0;
  ASSERT_GT(there, 5'000u);
  Patchwork oracle = sparseOracle(scene);
  const Deviation found = oracle.error({}, 0, above(*scene, 2), kLens);
  EXPECT_GE(found.uncovered, there);
  EXPECT_LE(found.uncovered, there + on_borders);
}

INSTANTIATE_TEST_SUITE_P(Frames, SparseOracle, testing::Values(FrameKind::kPlanar, FrameKind::kGeographic),
                         [](const auto& kind) { return kind.param == FrameKind::kPlanar ? "Planar" : "Geographic"; });

}  // namespace
}  // namespace foreland::oracle
