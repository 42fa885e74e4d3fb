// Flights over scenes whose finest levels are there only in places: the laws of a session hold as over any other.
#include <gtest/gtest.h>

#include "oracle/crack_checker.h"
#include "sim/world.h"
#include "tests/support/sparse_scene.h"

namespace foreland::test {
namespace {

using proto::FrameKind;
using sim::ClientOptions;
using sim::onKnownTour;
using sim::World;

std::shared_ptr<const terrain::Scene> sparseHills(FrameKind kind) {
  return makeSparseScene(301, 217, hills(11), kind, 4, {{90, 80, 50}, {220, 150, 20}});
}

class Sparse : public testing::TestWithParam<FrameKind> {};

// Both ends hold the section of refinement from scratch, with the true heights (sim/world.h), across a connection that
// is lost; and what is drawn has no cracks.
TEST_P(Sparse, ScenesAreFlownOverByAllLaws) {
  const auto scene = sparseHills(GetParam());
  ASSERT_TRUE(scene->isSparse());
  for (const char* tour : {"survey", "canyon", "spin"}) {
    World world(scene, {}, Duration::milliseconds(4), 1);
    world.addClient(onKnownTour(*scene, tour, 60));
    uint64_t cracks = 0, deep = 0;
    uint32_t checked = 0;
    world.on_frame = [&](size_t, const client::FrameView& view, Time) {
      if (view.mesh_version < checked + 5) return;
      checked = view.mesh_version;
      cracks += oracle::findCracks(*view.mesh, scene->grid().shape()).cracks;
      for (const proto::Slot slot : world.viewer(0).replica()->section().slots) {
        ASSERT_TRUE(scene->pages().hasPage(slot)) << tour;
        deep += slot >= scene->pages().wholeSlots() ? 1 : 0;
      }
    };
    world.run(Time::seconds(4));
    world.loseConnection(0);
    world.run(Time::seconds(4.5));
    world.connectAgain(0);
    world.run(Time::seconds(8));
    EXPECT_EQ(world.report(), "") << tour;
    EXPECT_EQ(cracks, 0u) << tour;
    EXPECT_GT(deep, 0u) << tour;
    EXPECT_EQ(world.viewer(0).statistics().resumed, 1u) << tour;
    EXPECT_GE(world.viewer(0).statistics().keyframes, 25u) << tour;
  }
}

INSTANTIATE_TEST_SUITE_P(Frames, Sparse, testing::Values(FrameKind::kPlanar, FrameKind::kGeographic),
                         [](const auto& kind) { return kind.param == FrameKind::kPlanar ? "Planar" : "Geographic"; });

TEST(SparseScenes, AreServedWithOcclusion) {
  for (const FrameKind kind : {FrameKind::kPlanar, FrameKind::kGeographic}) {
    const auto world = server::openWorld(sparseHills(kind), server::Occlusion::kOn);
    ASSERT_TRUE(world.ok()) << world.error().message;
    EXPECT_NE((*world)->occlusion, nullptr);
  }
}

}  // namespace
}  // namespace foreland::test
