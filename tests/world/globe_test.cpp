// Flights over a small planet: over poles, edges and corners of its cube the laws of a session hold as anywhere.
#include <gtest/gtest.h>

#include <algorithm>

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

// From whichever face a point of an edge is named, the ground there is the same.
TEST(Globes, HaveOneGroundOverEdges) {
  const auto scene = makeGlobeScene(6, 5);
  const proto::GridTopology& grid = scene->grid();
  World world(scene, {}, Duration::milliseconds(4), 1);
  world.addClient(onKnownTour(*scene, "orbit", 8));
  world.run(Time::seconds(3));
  const client::Replica& replica = *world.viewer(0).replica();
  size_t on_edges = 0;
  for (const proto::Slot slot : replica.section().slots) {
    const proto::NodeId n = grid.node(slot);
    for (const proto::CubePlace& place : grid.cube().placesOf(n)) {
      const double inside = grid.rootSize() - 1e-9;  // the last point of a face by its own coordinates
      const double x = 1.0 * place.face * grid.rootSize() + std::min<double>(place.x, inside),
                   y = std::min<double>(place.y, inside);
      const auto height_m = replica.heightAt(x, y);
      ASSERT_TRUE(height_m.has_value());
      ASSERT_NEAR(*height_m, scene->height(n) * scene->frame().height_quantum_m, 1e-3);
    }
    on_edges += grid.isOnSeam(n);
  }
  EXPECT_GT(on_edges, 20u);
}

TEST(Globes, AreServedWithOcclusion) {
  const auto scene = makeGlobeScene(5, 3);
  for (const auto occlusion : {server::Occlusion::kOn, server::Occlusion::kAuto}) {
    const auto world = server::openWorld(scene, occlusion);
    ASSERT_TRUE(world.ok());
    EXPECT_NE((*world)->occlusion, nullptr);
  }
}

}  // namespace
}  // namespace foreland::test
