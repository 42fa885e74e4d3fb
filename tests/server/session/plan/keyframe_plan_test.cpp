// When keyframes are due, of any state that a session may be in: on the client's grid, after the last one, no sooner
// than real time allows, and with `predict` as early as the viewer needs them.
#include "server/session/plan/keyframe_plan.h"

#include <gtest/gtest.h>

#include <rapidcheck.h>
#include <algorithm>

namespace foreland::server {
namespace {

Duration someDuration(int64_t from_ms, int64_t to_ms) {
  return Duration::milliseconds(*rc::gen::inRange<int64_t>(from_ms, to_ms));
}

// Clocks that differ by a second, and a link of 20 to 300 ms.
struct Scenario {
  KeyframeState state;
  ClockMap clocks;
  PlanOptions options;
};

Scenario some() {
  Scenario s;
  KeyframeState& state = s.state;
  state.grid = someDuration(20, 500);
  state.interval = state.grid * *rc::gen::inRange<int64_t>(1, 5);
  state.last_step = state.grid * *rc::gen::inRange<int64_t>(1, 5);
  state.order = *rc::gen::inRange<uint32_t>(1, 4);
  state.predicts = *rc::gen::arbitrary<bool>();
  state.compute_time = someDuration(1, 100);
  state.now = Time::seconds(100) + someDuration(0, 1000);
  state.newest_client = Time::seconds(99) + someDuration(0, 900);
  if (*rc::gen::arbitrary<bool>()) {
    state.last_client = gridAtOrAfter(state.newest_client - someDuration(0, 2000), state.grid);
    state.last_computed = state.now - someDuration(0, 2000);
    state.before_last_computed = state.last_computed - someDuration(0, 500);
    state.was_after_jump = *rc::gen::arbitrary<bool>();
  }
  s.options = {Duration::milliseconds(15), someDuration(0, 100), someDuration(0, 30)};
  for (int i = 0; i < 5; ++i) {
    const Time sent = Time::seconds(98) + Duration::milliseconds(100 * i);
    s.clocks.poseArrived(sent - Duration::seconds(1), sent + someDuration(10, 150));
    s.clocks.keyframeArrived(sent + someDuration(10, 150) - Duration::seconds(1), sent);
  }
  return s;
}

bool isOnGrid(const KeyframeState& state, Time t) { return t.us % state.grid.us == 0; }

// By when a keyframe for `t` must be sent, told from the texts of the strategy: it is needed when the display reaches
// the keyframe before it, or (order - 1) / 2 intervals sooner.
Time neededBy(const Scenario& s, Time t) {
  const Duration lead = s.state.interval + Duration{s.state.interval.us * (s.state.order - 1) / 2};
  return s.clocks.sendBy(t - lead) - s.options.safety;
}

TEST(Grid, HasOnePointInEachInterval) {
  EXPECT_TRUE(rc::check([] {
    const Duration grid = someDuration(1, 1000);
    const Time t{*rc::gen::inRange<int64_t>(-10'000'000, 10'000'000)};
    const Time at = gridAtOrAfter(t, grid);
    RC_ASSERT(at.us % grid.us == 0);
    RC_ASSERT(at >= t && at < t + grid);
  }));
}

TEST(Target, IsOnTheGridAfterTheLastKeyframeAndInTime) {
  EXPECT_TRUE(rc::check([] {
    const Scenario s = some();
    const Time target = targetOf(s.state, s.clocks, s.options.safety, std::nullopt);
    RC_ASSERT(isOnGrid(s.state, target));
    if (s.state.last_client) RC_ASSERT(target > *s.state.last_client);
    const auto isInTime = [&](Time t) { return neededBy(s, t) >= s.state.now + s.state.compute_time; };
    // It is the first such grid point, or one that was in time already when the next keyframe was.
    const Time sooner = target - s.state.grid;
    const bool is_next = s.state.last_client
                             ? sooner < *s.state.last_client + s.state.interval - s.state.grid + Duration{1}
                             : sooner < s.state.newest_client;
    RC_ASSERT(is_next || (isInTime(target) && !isInTime(sooner)));
  }));
}

TEST(Target, IsKeptUntilItsKeyframeWouldBeLateByHalfAnInterval) {
  EXPECT_TRUE(rc::check([] {
    const Scenario s = some();
    const Time before = gridAtOrAfter(s.state.newest_client + someDuration(-1000, 2000), s.state.grid);
    const bool is_kept = targetOf(s.state, s.clocks, s.options.safety, before) == before;
    if (neededBy(s, before) + Duration{s.state.interval.us / 2} >= s.state.now) RC_ASSERT(is_kept);
    // Whatever was chosen is chosen again.
    const Time target = targetOf(s.state, s.clocks, s.options.safety, before);
    RC_ASSERT(targetOf(s.state, s.clocks, s.options.safety, target) == target);
  }));
}

TEST(Plan, WaitsForAPoseOrATarget) {
  EXPECT_TRUE(rc::check([] {
    Scenario s = some();
    if (s.state.predicts) {
      RC_ASSERT(!planKeyframe(s.state, s.clocks, s.options, std::nullopt));
      return;
    }
    const auto plan = planKeyframe(s.state, s.clocks, s.options, std::nullopt);
    if (!plan) {
      RC_ASSERT(s.state.last_client && s.state.newest_client < *s.state.last_client + s.state.interval);
      return;
    }
    RC_ASSERT(plan->time_client <= s.state.newest_client);
    if (!s.state.last_client) return;
    RC_ASSERT(isOnGrid(s.state, plan->time_client));
    RC_ASSERT(plan->time_client > *s.state.last_client);
    RC_ASSERT(plan->time_client + s.state.grid > s.state.newest_client);
  }));
}

TEST(Plan, EndsWhenThePredictedKeyframeIsNeeded) {
  EXPECT_TRUE(rc::check([] {
    Scenario s = some();
    s.state.predicts = true;
    s.state.before_last_computed = {};  // long ago
    const Time target = targetOf(s.state, s.clocks, s.options.safety, std::nullopt);
    const auto plan = planKeyframe(s.state, s.clocks, s.options, target);
    RC_ASSERT(plan && plan->time_client == target);
    RC_ASSERT(plan->due.deadline == neededBy(s, target));
    const Time latest = plan->due.deadline - s.state.compute_time;
    RC_ASSERT(plan->due.release <= latest);
    if (s.options.max_early == Duration{} || s.state.isFirst()) {
      RC_ASSERT(plan->due.release == latest && !plan->due.earliest);
    } else {
      RC_ASSERT(*plan->due.earliest <= plan->due.release);
      RC_ASSERT(latest - *plan->due.earliest <= Duration{s.state.grid.us / 2});
    }
  }));
}

// With `predict` for when it arrives, else for the newest pose, but after the coarse one in any case.
TEST(Plan, RefinesACoarseSectionAtOnce) {
  EXPECT_TRUE(rc::check([] {
    Scenario s = some();
    s.state.is_coarse = true;
    if (!s.state.last_client) s.state.last_client = s.state.newest_client - someDuration(0, 10);
    const auto plan = planKeyframe(s.state, s.clocks, s.options, std::nullopt);
    if (!plan) {
      RC_ASSERT(!s.state.predicts && s.state.newest_client <= *s.state.last_client);
      return;
    }
    RC_ASSERT(plan->due.release == s.state.now && plan->due.deadline <= s.state.now + s.state.grid);
    RC_ASSERT(plan->time_client > *s.state.last_client);
    if (!s.state.predicts)
      RC_ASSERT(plan->time_client == s.state.newest_client);
    else
      RC_ASSERT(s.clocks.sendBy(plan->time_client) == s.state.now + s.state.compute_time ||
                plan->time_client == *s.state.last_client + Duration{1});
  }));
}

// A client's clock that runs ten times as fast makes no more work.
TEST(Plan, MakesHardlyMoreThanTwoKeyframesInAnIntervalOfTheServer) {
  EXPECT_TRUE(rc::check([] {
    Scenario s = some();
    s.state.has_jumped = *rc::gen::arbitrary<bool>();
    const std::optional<Time> target =
        s.state.predicts ? std::optional(targetOf(s.state, s.clocks, s.options.safety, std::nullopt)) : std::nullopt;
    const auto plan = planKeyframe(s.state, s.clocks, s.options, target);
    if (!plan || s.state.isFirst()) return;
    const Duration eighth{s.state.grid.us / 8};
    RC_ASSERT(plan->due.release >= s.state.before_last_computed + s.state.grid - eighth - Duration{1});
    RC_ASSERT(plan->due.deadline >= s.state.before_last_computed + s.state.grid - eighth - Duration{1});
    if (s.state.has_jumped && s.state.was_after_jump)
      RC_ASSERT(plan->due.release >= s.state.last_computed + s.state.grid);
    if (s.state.has_jumped) RC_ASSERT(plan->time_client == s.state.newest_client && plan->skipped == 0);
    const auto most = static_cast<uint64_t>((s.state.now - s.state.last_computed).us / s.state.grid.us) + 1;
    RC_ASSERT(plan->skipped <= most);
  }));
}

}  // namespace
}  // namespace foreland::server
