// A connection is lost and there is another: the viewer's section is all the state that there is.
#include <gtest/gtest.h>

#include <array>

#include "oracle/crack_checker.h"
#include "sim/world.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

using sim::ClientOptions;
using sim::onKnownTour;
using sim::World;

std::shared_ptr<const terrain::Scene> hillsOf(uint64_t seed) { return makeScene(301, 217, seed); }

TEST(Resume, ContinuesFromTheSectionAfterASecondOrAnHour) {
  const auto scene = hillsOf(11);
  for (double outage_s : {0.01, 1.0, 3600.0}) {
    World world(scene, {}, Duration::milliseconds(4), 1);
    world.addClient(onKnownTour(*scene, "survey", 60));
    uint64_t cracks = 0;
    uint32_t checked = 0;
    world.on_frame = [&](size_t, const client::FrameView& view, Time) {
      if (std::exchange(checked, view.mesh_version) != view.mesh_version)
        cracks += oracle::findCracks(*view.mesh, scene->grid().shape()).cracks;
    };
    world.run(Time::seconds(3));
    world.loseConnection(0);
    world.run(Time::seconds(3 + outage_s));
    const uint64_t before = world.viewer(0).statistics().bytes_down;
    const uint32_t keyframes = world.viewer(0).statistics().keyframes;
    world.connectAgain(0);
    world.run(Time::seconds(4 + outage_s));
    EXPECT_EQ(world.report(), "") << outage_s;
    EXPECT_EQ(cracks, 0u);
    EXPECT_EQ(world.viewer(0).statistics().resumed, 1u) << outage_s;
    EXPECT_EQ(world.viewer(0).statistics().started_afresh, 0u) << outage_s;
    EXPECT_GE(world.viewer(0).statistics().keyframes, keyframes + 3) << outage_s;
    if (outage_s <= 1) { EXPECT_LT(world.viewer(0).statistics().bytes_down - before, before) << "not all of it again"; }
  }
}

// A camera that turns in place has seen everything after a turn. Presented to another server, it is not sent again; a
// viewer that remembers nothing is sent what comes into view.
TEST(Resume, PresentsWhatIsRemembered) {
  const auto scene = hillsOf(15);
  std::array<uint64_t, 2> bytes{};
  for (uint32_t memory_bytes : {0u, proto::kDefaultMemoryBytes}) {
    World world(scene, {}, Duration::milliseconds(4), 4);
    ClientOptions options = onKnownTour(*scene, "spin", 60);
    options.request.memory_bytes = memory_bytes;
    world.addClient(options);
    world.run(Time::seconds(8));
    world.loseConnection(0);
    world.run(Time::seconds(8.5));
    world.connectAgain(0);
    world.run(Time::seconds(9));
    const uint64_t begun = world.viewer(0).statistics().bytes_down;
    world.run(Time::seconds(13));
    EXPECT_EQ(world.report(), "");
    EXPECT_EQ(world.viewer(0).statistics().resumed, 1u);
    bytes[memory_bytes == 0 ? 0 : 1] = world.viewer(0).statistics().bytes_down - begun;
  }
  EXPECT_LT(10 * bytes[1], bytes[0]) << "a turn after resuming, with and without memory";
}

TEST(Resume, LosesTheConnectionAgainAndAgain) {
  const auto scene = hillsOf(12);
  World world(scene, {}, Duration::milliseconds(4), 2);
  world.addClient(onKnownTour(*scene, "survey", 60));
  double t = 1;
  for (int i = 0; i < 20; ++i) {
    world.run(Time::seconds(t += 0.13 * (1 + i % 5)));
    world.loseConnection(0);
    world.run(Time::seconds(t += 0.05 * (i % 3)));
    world.connectAgain(0);
  }
  world.run(Time::seconds(t + 2));
  EXPECT_EQ(world.report(), "");
  const client::ViewerStatistics& s = world.viewer(0).statistics();
  EXPECT_GT(s.resumed, 10u);
  EXPECT_EQ(s.started_afresh, 0u);
}

TEST(Resume, StartsAfreshOnAnotherScene) {
  const auto scene = hillsOf(13), other = hillsOf(14);
  World world(scene, {}, Duration::milliseconds(4), 3);
  world.addClient(onKnownTour(*scene, "survey", 60));
  world.run(Time::seconds(3));
  world.loseConnection(0);
  world.run(Time::seconds(3.5));
  world.connectAgain(0, other);
  world.run(Time::seconds(6));
  EXPECT_EQ(world.report(), "");
  EXPECT_EQ(world.viewer(0).welcome()->scene_id, other->id());
  EXPECT_EQ(world.viewer(0).statistics().resumed, 0u);
  EXPECT_EQ(world.viewer(0).statistics().started_afresh, 1u);
  EXPECT_EQ(world.viewer(0).replica()->section(), world.session(0).section());
}

}  // namespace
}  // namespace foreland::test
