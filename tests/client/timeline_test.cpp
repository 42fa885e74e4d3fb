// Which mesh is shown when: the laws of the header first, then one example for each strategy.
#include "client/timeline.h"

#include <gtest/gtest.h>

#include "base/rng.h"

namespace foreland::client {
namespace {

using proto::Strategy;

Time at(double ms) { return Time{} + Duration{static_cast<int64_t>(ms * 1000)}; }

// The mesh from the keyframe at `from_ms` with index `index` to the next one at `to_ms`.
std::shared_ptr<MeshPatch> mesh(uint32_t index, double from_ms, double to_ms) {
  auto made = std::make_shared<MeshPatch>();
  made->from.index = index;
  made->from.time = at(from_ms);
  made->to.index = index + 1;
  made->to.time = at(to_ms);
  return made;
}

std::shared_ptr<MeshPatch> stillMesh(double ms) {
  auto made = mesh(1, ms, ms);
  made->to.index = 1;
  return made;
}

TEST(Timeline, NeverGoesBackAndNeverSkipsWhateverTheArrivals) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  for (Strategy strategy : {Strategy::kDelay, Strategy::kCurrent, Strategy::kPredict}) {
    Timeline timeline;
    timeline.add(stillMesh(0), at(100), strategy);
    double arrival = 100;
    uint32_t next = 1;
    Timeline::Shown last;
    for (double now = 100; now < 20'000; now += 5) {
      if (now >= arrival && next < 80) {
        timeline.add(mesh(next, 200.0 * (next - 1), 200.0 * next), at(now), strategy);
        arrival = std::max(arrival, 200.0 * next++) + rng.uniform(0, rng.below(10) == 0 ? 900 : 60);
        // A server has no more than that on its way (server/session).
        arrival = std::min(arrival, 200.0 * next + 1600);
      }
      const Timeline::Shown shown = timeline.at(at(now));
      ASSERT_NE(shown.mesh, nullptr);
      ASSERT_GE(shown.weight, 0);
      ASSERT_LE(shown.weight, 1);
      ASSERT_GE(shown.shown_time, last.shown_time) << now;
      ASSERT_LE(shown.version - last.version, last.version > 0 ? 1u : 2u) << now;
      if (shown.version != last.version && last.version > 0) {
        // 5 ms of at least kShortestBlend at either side of the change.
        ASSERT_GE(last.weight, 0.9 - 1e-9) << now;
        ASSERT_LE(shown.weight, 0.1 + 1e-9) << now;
      }
      last = shown;
    }
    EXPECT_EQ(last.version, 80u);
    EXPECT_TRUE(last.is_over);
  }
}

TEST(Timeline, ShowsNothingBeforeTheFirstMeshAndAfterClear) {
  Timeline timeline;
  EXPECT_EQ(timeline.at(at(0)).mesh, nullptr);
  EXPECT_EQ(timeline.add(stillMesh(0), at(10), Strategy::kPredict), Duration{});
  const uint32_t version = timeline.at(at(10)).version;
  EXPECT_GT(version, 0u);
  timeline.clear();
  EXPECT_EQ(timeline.at(at(20)).mesh, nullptr);
  timeline.add(stillMesh(0), at(30), Strategy::kPredict);
  EXPECT_GT(timeline.at(at(30)).version, version) << "versions are not reused";
}

TEST(Timeline, PredictShowsTheTimeThatItIs) {
  Timeline timeline;
  timeline.add(stillMesh(0), at(0), Strategy::kPredict);
  EXPECT_EQ(timeline.add(mesh(1, 200, 400), at(150), Strategy::kPredict), Duration::milliseconds(-50));
  for (double now : {200.0, 250.0, 300.0, 399.0}) {
    const auto shown = timeline.at(at(now));
    EXPECT_NEAR(shown.weight, (now - 200) / 200, 1e-9);
    EXPECT_EQ(shown.shown_time, at(now));
    EXPECT_FALSE(shown.is_over);
  }
  EXPECT_TRUE(timeline.at(at(400)).is_over);
}

TEST(Timeline, DelayShowsTheSceneLaterByTheIntervalAndThePlayoutDelay) {
  Timeline timeline;
  timeline.add(stillMesh(0), at(30), Strategy::kDelay);
  timeline.add(mesh(1, 0, 200), at(230), Strategy::kDelay);
  // The latency is 30 ms, and the margin 10 ms: from.time + T + playout delay = 240 ms.
  EXPECT_EQ(timeline.at(at(240)).weight, 0);
  EXPECT_NEAR(timeline.at(at(340)).weight, 0.5, 1e-9);
  EXPECT_EQ(timeline.at(at(340)).shown_time, at(100));
  EXPECT_EQ(timeline.at(at(440)).shown_time, at(200));
}

TEST(Timeline, DelayIsThatOfTheLongestIntervalWhereTheyAdapt) {
  Timeline timeline;
  timeline.setInterval({Duration::milliseconds(100), Duration::milliseconds(500)});
  timeline.add(stillMesh(0), at(0), Strategy::kDelay);
  double from = 0;
  uint32_t index = 1;
  // The latency is 0, and the margin 10 ms.
  for (const double interval : {100.0, 500.0, 200.0, 100.0, 400.0}) {
    timeline.add(mesh(index++, from, from + interval), at(from + interval), Strategy::kDelay);
    for (double share = 0.25; share < 1; share += 0.25)
      EXPECT_EQ(timeline.at(at(from + share * interval + 510)).shown_time, at(from + share * interval));
    from += interval;
  }
}

// Of order 2: three keyframes are blended, and what is in the middle of them is shown.
std::shared_ptr<MeshPatch> splineMesh(uint32_t index, double from_ms, double to_ms) {
  auto made = mesh(index, from_ms, to_ms);
  made->earlier.count = 1;
  made->earlier.from_age = made->earlier.to_age = at((to_ms - from_ms) / 2) - Time{};
  return made;
}

TEST(Timeline, OfAHigherOrderShowsWhatIsInTheMiddleOfItsKeyframes) {
  Timeline predicted, delayed;
  predicted.add(stillMesh(0), at(0), Strategy::kPredict);
  delayed.add(stillMesh(0), at(30), Strategy::kDelay);
  EXPECT_EQ(predicted.add(splineMesh(1, 200, 400), at(50), Strategy::kPredict), Duration::milliseconds(-50));
  delayed.add(splineMesh(1, 200, 400), at(430), Strategy::kDelay);
  for (const double shown : {100.0, 150.0, 275.0}) {
    EXPECT_EQ(predicted.at(at(shown)).shown_time, at(shown));
    EXPECT_NEAR(predicted.at(at(shown)).weight, (shown - 100) / 200, 1e-9);
    // A latency of 30 ms, 10 ms of margin, and an interval and a half.
    EXPECT_EQ(delayed.at(at(shown + 340)).shown_time, at(shown));
  }
}

TEST(Timeline, ALateMeshBeginsOnArrivalEndsInTimeAndLastsTheShortestBlendAtLeast) {
  Timeline timeline;
  timeline.add(stillMesh(0), at(0), Strategy::kPredict);
  EXPECT_EQ(timeline.add(mesh(1, 200, 400), at(300), Strategy::kPredict), Duration::milliseconds(100));
  EXPECT_EQ(timeline.at(at(300)).weight, 0);
  EXPECT_NEAR(timeline.at(at(350)).weight, 0.5, 1e-9);
  EXPECT_EQ(timeline.add(mesh(2, 400, 600), at(590), Strategy::kPredict), Duration::milliseconds(190));
  EXPECT_EQ(timeline.at(at(590)).weight, 0);
  EXPECT_NEAR(timeline.at(at(615)).weight, 0.5, 1e-9) << "50 ms from its arrival";
  EXPECT_TRUE(timeline.at(at(640)).is_over);
}

// By a time stamp that was wrong the keyframe before was for an hour later; the next ones are shown as they would be
// after a first one.
TEST(Timeline, DoesNotWaitForATimeThatWasWrong) {
  for (Strategy strategy : {Strategy::kDelay, Strategy::kCurrent, Strategy::kPredict}) {
    Timeline timeline;
    timeline.add(stillMesh(0), at(30), strategy);
    ASSERT_NE(timeline.at(at(40)).mesh, nullptr);
    timeline.add(mesh(1, 0, 3'600'000), at(200), strategy);
    timeline.add(mesh(2, 3'600'000, 400), at(430), strategy);
    EXPECT_EQ(timeline.at(at(430)).mesh->to.index, 3u);
    EXPECT_EQ(timeline.at(at(430)).weight, 1);
    timeline.add(mesh(3, 400, 600), at(630), strategy);
    EXPECT_EQ(timeline.at(at(1200)).mesh->to.index, 4u);
    EXPECT_EQ(timeline.at(at(1200)).weight, 1);
  }
}

// The first interval is a fault, and so no measure of those that are usual.
// The server sends what was not to be had at once as soon as it can; what is coarse is not shown for longer than that.
TEST(Timeline, ShowsWhatRefinesAStillMeshAsItArrives) {
  for (Strategy strategy : {Strategy::kDelay, Strategy::kCurrent, Strategy::kPredict})
    for (const float tau_px : {1.f, 4.f}) {
      Timeline timeline;
      const auto coarse = stillMesh(1000), finer = mesh(1, 1000, 1040);
      coarse->from.tau_px = coarse->to.tau_px = finer->from.tau_px = 4;
      finer->to.tau_px = tau_px;
      timeline.add(coarse, at(1100), strategy);
      const Duration lateness = timeline.add(finer, at(1170), strategy);
      const bool refines = tau_px < 4;
      EXPECT_EQ(lateness == Duration{}, refines);
      if (refines) {
        EXPECT_EQ(timeline.at(at(1169)).version, 1u);
        EXPECT_EQ(timeline.at(at(1170)).version, 2u);
        EXPECT_EQ(timeline.at(at(1170) + Timeline::kShortestBlend).weight, 1);
      }
    }
}

TEST(Timeline, CatchesUpWithAnOutageRightAfterTheFirstKeyframe) {
  for (Strategy strategy : {Strategy::kDelay, Strategy::kCurrent}) {
    Timeline timeline;
    timeline.setInterval({Duration::milliseconds(200), {}});
    timeline.add(stillMesh(0), at(30), strategy);
    timeline.add(mesh(1, 0, 60'000), at(60'030), strategy);
    Timeline::Shown shown;
    for (uint32_t i = 2; i < 20; ++i) {
      const double from = 60'000 + 200.0 * (i - 2);
      shown = timeline.at(at(from + 229));
      timeline.add(mesh(i, from, from + 200), at(from + 230), strategy);
    }
    // An interval, 30 ms of latency and 10 ms of margin behind.
    EXPECT_EQ(shown.shown_time, at(60'000 + 200 * 17 + 229 - 240));
  }
}

// Two stalls: one of the way down, which the playout delay grows by, and one of the way up, for which there is no
// keyframe. The display waits for one of them, not for both.
TEST(Timeline, AllowsForOneStallNotForTwo) {
  Timeline timeline;
  timeline.setInterval({Duration::milliseconds(200), {}});
  timeline.add(stillMesh(0), at(30), Strategy::kDelay);
  timeline.add(mesh(1, 0, 200), at(2100), Strategy::kDelay);
  timeline.add(mesh(2, 200, 400), at(2100), Strategy::kDelay);
  timeline.add(mesh(3, 400, 2600), at(2630), Strategy::kDelay);
  EXPECT_GT(timeline.at(at(3000)).shown_time, at(400));
  EXPECT_EQ(timeline.at(at(4840)).shown_time, at(2600));
}

TEST(Timeline, ExtendsAfterTheLastMesh) {
  Timeline timeline;
  timeline.add(stillMesh(0), at(0), Strategy::kPredict);
  timeline.add(mesh(1, 0, 200), at(0), Strategy::kPredict);
  auto extension = mesh(2, 200, 200);
  extension->to.index = 2;
  timeline.extend(extension);
  EXPECT_EQ(timeline.at(at(199)).mesh->to.index, 2u);
  EXPECT_EQ(timeline.at(at(199)).mesh->from.index, 1u);
  EXPECT_EQ(timeline.at(at(200)).mesh, extension.get());
  EXPECT_NEAR(timeline.at(at(325)).weight, 0.5, 1e-9);
  EXPECT_TRUE(timeline.at(at(450)).is_over);
}

TEST(Timeline, KeepsTheNewestMeshesOnlyWhenNothingIsDrawn) {
  Timeline timeline;
  timeline.add(stillMesh(0), at(0), Strategy::kPredict);
  std::weak_ptr<MeshPatch> oldest;
  for (uint32_t i = 1; i < Timeline::kMaxUndrawn; ++i) {
    const auto made = mesh(i, 200.0 * i, 200.0 * (i + 1));
    if (i == 1) oldest = made;
    timeline.add(made, at(0), Strategy::kPredict);
  }
  EXPECT_FALSE(oldest.expired());
  timeline.add(mesh(8, 1600, 1800), at(0), Strategy::kPredict);
  timeline.add(mesh(9, 1800, 2000), at(0), Strategy::kPredict);
  EXPECT_TRUE(oldest.expired());
}

TEST(Timeline, ShowsEveryMeshOfABurstWhenTheHostDraws) {
  Timeline timeline;
  timeline.add(stillMesh(0), at(0), Strategy::kPredict);
  uint32_t next = 1;
  double now = 0;
  for (int burst = 0; burst < 2; ++burst) {
    for (size_t i = 0; i < Timeline::kMaxUndrawn; ++i, ++next)
      timeline.add(mesh(next, 10.0 * next, 10.0 * (next + 1)), at(now), Strategy::kPredict);
    now += 5;
    timeline.at(at(now));
  }
  const uint32_t first = timeline.at(at(now)).version;
  uint32_t last = first;
  for (; !timeline.at(at(now)).is_over; now += 5) {
    const uint32_t shown = timeline.at(at(now)).version;
    ASSERT_LE(shown, last + 1);
    last = shown;
  }
  EXPECT_EQ(last, next) << "one version for the first mesh";
  EXPECT_LE(first, 2u);
}

}  // namespace
}  // namespace foreland::client
