// For which viewers what is hidden is left out, and when they are judged.
#include "server/session/plan/occlusion_control.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace foreland::server {
namespace {

using Effort = OcclusionControl::Effort;

Time at(double s) { return Time::seconds(s); }
Duration ms(int64_t t) { return Duration::milliseconds(t); }

struct Flown {
  double begin_s, end_s;
  double share = 1;
  size_t with_hidden = 3000;  // of a section that has 1000 without
  Duration all = ms(2), occlusion = ms(1);
};

// Five keyframes a second; what fades has faded after two seconds. Calls `see` after each.
void fly(
    OcclusionControl& control, const Flown& f, const std::function<void(double)>& see = [](double) {}) {
  double fading_since = -1;
  for (double t = f.begin_s; t < f.end_s; t += 0.2) {
    const Effort effort = control.next(at(t), f.share, 0.5, false);
    fading_since = effort == Effort::kFading ? (fading_since < 0 ? t : fading_since) : -1;
    control.observe(f.all, effort == Effort::kNone ? Duration{} : f.occlusion, t - fading_since < 2);
    if (control.isComparisonDue(at(t), Duration{200})) control.compared(at(t), 1000, f.with_hidden);
    see(t);
  }
}

TEST(OcclusionControl, LeavesOutWhatIsHiddenWhileThereIsRoom) {
  OcclusionControl control;
  fly(control, {0, 60}, [&](double) { EXPECT_EQ(control.effort(), Effort::kAll); });
  EXPECT_NEAR(control.leftOut(), 2, 1e-9);
  EXPECT_EQ(control.timesShed() + control.timesWorthless(), 0u);
}

TEST(OcclusionControl, FadesBeforeItEndsWhereThereIsNoRoomAndBeginsAgain) {
  OcclusionControl control;
  fly(control, {0, 2});
  bool has_faded = false;
  fly(control, {2, 10, 0.4}, [&](double) {
    has_faded = has_faded || control.effort() == Effort::kFading;
    if (control.effort() == Effort::kNone) { EXPECT_TRUE(has_faded); }
  });
  EXPECT_EQ(control.effort(), Effort::kNone);
  EXPECT_EQ(control.timesShed(), 1u);
  fly(control, {10, 11, 0.6});
  EXPECT_EQ(control.effort(), Effort::kAll);
}

TEST(OcclusionControl, StaysWhereTheKeyframeWouldTakeAsLongWithout) {
  OcclusionControl control;
  const Duration little{100};
  fly(control, {.begin_s = 0, .end_s = 60, .occlusion = little});
  fly(control, {.begin_s = 60, .end_s = 80, .share = 0, .occlusion = little});
  EXPECT_EQ(control.effort(), Effort::kAll);
}

// What hides nothing is judged after some seconds, then tried more and more seldom; what is as cheap as nothing stays.
TEST(OcclusionControl, IsTriedMoreAndMoreSeldomWhereLittleIsLeftOut) {
  OcclusionControl control;
  double used_s = 0, first_rest_s = 0, last_rest_s = 0, rest_s = 0;
  fly(control, {.begin_s = 0, .end_s = 600, .with_hidden = 1040}, [&](double) {
    used_s += control.effort() == Effort::kNone ? 0 : 0.2;
    if (control.effort() == Effort::kNone) {
      rest_s += 0.2;
    } else if (rest_s > 0) {
      first_rest_s = first_rest_s > 0 ? first_rest_s : rest_s;
      last_rest_s = rest_s;
      rest_s = 0;
    }
  });
  EXPECT_LT(used_s, 100);
  EXPECT_GT(control.timesWorthless(), 3u);
  EXPECT_GT(last_rest_s, 4 * first_rest_s);
  OcclusionControl cheap;
  fly(cheap, {.begin_s = 0, .end_s = 600, .with_hidden = 1040, .occlusion = Duration{20}});
  EXPECT_EQ(cheap.effort(), Effort::kAll);
}

TEST(OcclusionControl, ComparesForATenthOfWhatProofsTake) {
  OcclusionControl control;
  constexpr double kCost_s = 0.007;
  double compared_s = 0;
  for (int i = 0; i < 3000; ++i) {
    const Time now = at(0.2 * i);
    control.next(now, 1, 0, false);
    control.observe(ms(2), ms(1), true);
    if (!control.isComparisonDue(now, Duration::seconds(kCost_s))) continue;
    compared_s += kCost_s;
    control.compared(now, 1000, 2000);
  }
  EXPECT_GT(compared_s, 0);
  EXPECT_LE(compared_s, 0.1 * 3000 * 1e-3);
}

TEST(OcclusionControl, RanksAnyViewersEvenly) {
  for (const uint64_t first : {0u, 1000u}) {
    int below = 0;
    for (uint64_t i = first; i < first + 100; ++i) below += OcclusionControl::rankOf(i) < 0.3;
    EXPECT_NEAR(below, 30, 2);
  }
}

}  // namespace
}  // namespace foreland::server
