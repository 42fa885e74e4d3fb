// Flights over a small planet: over poles, edges and corners of its cube the laws of a session hold as anywhere.
#include <gtest/gtest.h>

#include "oracle/crack_checker.h"
#include "sim/world.h"
#include "tests/support/globe_scene.h"

namespace foreland::test {
namespace {

using sim::onKnownTour;
using sim::World;

class Globe : public testing::TestWithParam<uint32_t> {};

// Both ends hold the section of refinement from scratch, with the true heights (sim/world.h), across a connection that
// is lost; and what is drawn has no cracks.
TEST_P(Globe, IsFlownOverByAllLaws) {
  const auto scene = makeGlobeScene(7, 3, GetParam());
  for (const char* tour : {"survey", "canyon", "spin", "orbit"}) {
    World world(scene, {}, Duration::milliseconds(4), 1);
    world.addClient(onKnownTour(*scene, tour, 8));
    uint64_t cracks = 0;
    std::string first;
    uint32_t checked = 0;
    world.on_frame = [&](size_t, const client::FrameView& view, Time) {
      if (view.mesh_version < checked + 3) return;
      checked = view.mesh_version;
      const oracle::CrackReport report = oracle::findCracks(*view.mesh, scene->grid().shape());
      if (cracks == 0) first = report.first;
      cracks += report.cracks;
    };
    world.run(Time::seconds(4));
    world.loseConnection(0);
    world.run(Time::seconds(4.5));
    world.connectAgain(0);
    world.run(Time::seconds(8));
    EXPECT_EQ(world.report(), "") << tour;
    EXPECT_EQ(cracks, 0u) << tour << ": " << first;
    EXPECT_EQ(world.viewer(0).statistics().resumed, 1u) << tour;
    EXPECT_GE(world.viewer(0).statistics().keyframes, 20u) << tour;
  }
}
INSTANTIATE_TEST_SUITE_P(SparseLevels, Globe, testing::Values(0, 5));

TEST(Globes, AreServedWithoutOcclusionOrRefused) {
  const auto scene = makeGlobeScene(5, 3);
  const auto with = server::openWorld(scene, server::Occlusion::kOn);
  ASSERT_FALSE(with.ok());
  EXPECT_NE(with.error().message.find("globes"), std::string::npos);
  const auto as_it_pays = server::openWorld(scene, server::Occlusion::kAuto);
  ASSERT_TRUE(as_it_pays.ok());
  EXPECT_EQ((*as_it_pays)->occlusion, nullptr);
}

}  // namespace
}  // namespace foreland::test
