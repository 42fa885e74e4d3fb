// What a thread that draws shows of meshes that another thread makes: equal to the time line where meshes are ready in
// time, and never a jump where they are not.
#include "client/schedule.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "base/rng.h"
#include "client/timeline.h"
#include "tests/support/seed.h"

namespace foreland::client {
namespace {

Time at(double ms) { return Time{} + Duration{static_cast<int64_t>(ms * 1000)}; }

Interval interval(uint32_t version, double begin_ms, double end_ms) {
  Interval made{.version = version, .begin = at(begin_ms), .end = at(end_ms), .from = {}, .to = {}};
  made.from.time = at(begin_ms);
  made.to.time = at(end_ms);
  return made;
}

std::shared_ptr<MeshPatch> mesh(uint32_t index, double from_ms, double to_ms) {
  auto made = std::make_shared<MeshPatch>();
  made->from.index = index;
  made->to.index = index + 1;
  made->from.time = at(from_ms);
  made->to.time = at(to_ms);
  return made;
}

// A host that is handed each interval when it is made shows the same as the time line itself.
TEST(Schedule, ShowsWhatTheTimelineShowsIfAllIsReady) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  for (proto::Strategy strategy : {proto::Strategy::kDelay, proto::Strategy::kCurrent, proto::Strategy::kPredict}) {
    Timeline timeline;
    Schedule schedule;
    double arrival = 100;
    uint32_t next = 0;
    for (double now = 100; now < 8000; now += rng.uniform(4, 30)) {
      for (; now >= arrival; ++next) {
        const bool jumps = next == 0 || rng.below(20) == 0;  // to a section that was sent whole
        auto made = mesh(next, jumps ? 200.0 * next : 200.0 * (next - 1.0), 200.0 * next);
        if (jumps) made->to.index = made->from.index;
        timeline.add(made, at(now), strategy);
        schedule.dropBefore(timeline.oldestVersion());
        schedule.add(*timeline.newest());
        arrival = std::max(arrival, 200.0 * next) + rng.uniform(0, rng.below(10) == 0 ? 900 : 60);
      }
      const Timeline::Shown wanted = timeline.at(at(now));
      const Schedule::Shown shown = schedule.at(at(now));
      ASSERT_NE(shown.interval, nullptr);
      ASSERT_EQ(shown.interval->version, wanted.version) << now;
      ASSERT_EQ(shown.weight, wanted.weight) << now;
      ASSERT_EQ(shown.shown_time, wanted.shown_time) << now;
    }
  }
}

// Meshes become ready in their order, each up to 700 ms after it is begun with, which is longer than an interval: what
// is shown holds still until then, and starts at the beginning.
TEST(Schedule, NeverJumpsHoweverLateMeshesAreReady) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  Schedule schedule;
  uint32_t made = 0, ready = 0, coming = 0, last = 0;
  const double start = 200.0 * std::round(rng.uniform(-200, 200));  // of a clock that begins anywhere
  double ready_at = 0, last_weight = 1;
  constexpr double kFrame = 5;
  for (double now = start; now < start + 20'000; now += kFrame) {
    if (now >= start + 200.0 * made) {
      ++made;
      schedule.add(interval(made, start + 200.0 * made, start + 200.0 * made + 200));
    }
    if (coming != 0 && now >= ready_at) ready = std::exchange(coming, 0);
    if (coming == 0 && ready <= last && schedule.next() > last) {
      coming = schedule.next();
      ready_at = now + rng.uniform(0, rng.below(4) == 0 ? 700 : 60);
    }
    const Schedule::Shown shown = schedule.at(at(now), ready, coming);
    if (shown.interval == nullptr) continue;
    ASSERT_LE(shown.interval->version, ready) << now;
    if (shown.interval->version == last) {
      ASSERT_GE(shown.weight, last_weight) << now;
    } else if (last > 0) {
      ASSERT_GT(shown.interval->version, last) << now;
      // A frame of at least kShortestBlend at either side of the change, and nothing that was skipped was in time.
      if (shown.interval->version == last + 1) { ASSERT_GE(last_weight, 0.9 - 1e-9) << now; }
      ASSERT_LE(shown.weight, 0.1 + 1e-9) << now;
    }
    last = shown.interval->version;
    last_weight = shown.weight;
  }
  EXPECT_GT(last, 50u);
}

TEST(Schedule, NamesTheNextMeshToMakeReadyPastThoseThatWillNotBeShown) {
  Schedule schedule;
  EXPECT_EQ(schedule.next(), 0u);
  schedule.add(interval(1, 0, 0));
  EXPECT_EQ(schedule.next(), 1u);
  EXPECT_EQ(schedule.at(at(0), 0).interval, nullptr);
  ASSERT_NE(schedule.at(at(5), 1).interval, nullptr);
  EXPECT_EQ(schedule.next(), 0u);
  for (uint32_t i = 2; i <= 5; ++i) schedule.add(interval(i, 200.0 * i, 200.0 * i + 200));
  EXPECT_EQ(schedule.next(), 2u);
  EXPECT_EQ(schedule.at(at(850), 1).interval->version, 1u);  // after a pause
  EXPECT_EQ(schedule.next(), 4u);
  EXPECT_EQ(schedule.at(at(900), 4).weight, 1.0 / 3);  // began at 850, and ends in time, at 1000
  schedule.dropBefore(9);
  schedule.add(interval(9, 901, 901));
  EXPECT_EQ(schedule.at(at(905), 4).interval->version, 4u) << "stays until the other one is ready";
  EXPECT_EQ(schedule.next(), 9u);
  EXPECT_EQ(schedule.at(at(910), 9).interval->version, 9u);
}

}  // namespace
}  // namespace foreland::client
