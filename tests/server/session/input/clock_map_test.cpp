// Two clocks with a fixed offset, and a link between them: what can be told of them from messages alone.
#include "server/session/input/clock_map.h"

#include <gtest/gtest.h>

#include "base/rng.h"

namespace foreland::server {
namespace {

constexpr Duration ms(int64_t n) { return Duration::milliseconds(n); }

// client time = server time + offset
struct Link {
  Duration offset, up, down;

  void pose(ClockMap& map, Time sent_server, Duration extra = {}) const {
    map.poseArrived(sent_server + offset, sent_server + up + extra);
  }
  void keyframe(ClockMap& map, Time sent_server, Duration extra = {}) const {
    map.keyframeArrived(sent_server + down + extra + offset, sent_server);
  }
};

TEST(ClockMap, IsUnknownUntilTheFirstPose) {
  ClockMap map;
  EXPECT_FALSE(map.isKnown());
  map.poseArrived(Time{5}, Time{7});
  EXPECT_TRUE(map.isKnown());
}

// Whatever the offset: what leaves at sendBy(t) arrives at t.
TEST(ClockMap, FindsWhenToSendWhateverTheOffsetIs) {
  for (const int64_t offset_ms : {-3'600'000, -20, 0, 1'000'000}) {
    const Link link{ms(offset_ms), ms(30), ms(45)};
    ClockMap map;
    for (int i = 0; i < 10; ++i) {
      link.pose(map, Time{} + ms(50 * i));
      link.keyframe(map, Time{} + ms(50 * i));
    }
    const Time now = Time{} + ms(1000);
    EXPECT_EQ(map.clientTime(now), now + link.offset - link.up);
    EXPECT_EQ(map.sendBy(now + link.offset), now - link.down);
  }
}

TEST(ClockMap, GuessesARoundTripBeforeAKeyframeIsAcknowledged) {
  const Link link{ms(500), ms(20), ms(0)};
  ClockMap map;
  link.pose(map, Time{});
  // L_up + L_down are taken to be 150 ms.
  EXPECT_EQ(map.sendBy(Time{} + ms(1000) + link.offset), Time{} + ms(1000 - 130));
}

TEST(ClockMap, JudgesByTheFastestPoses) {
  const Link link{ms(-70), ms(25), ms(25)};
  Rng rng(1);
  ClockMap map;
  link.pose(map, Time{});
  for (int i = 1; i < 30; ++i) link.pose(map, Time{} + ms(50 * i), ms(static_cast<int64_t>(rng.below(200))));
  EXPECT_EQ(map.clientTime(Time{} + ms(2000)), Time{} + ms(2000) + link.offset - link.up);
}

TEST(ClockMap, ForgetsALinkThatHasBecomeSlower) {
  ClockMap map;
  Link{ms(0), ms(10), ms(10)}.pose(map, Time{});
  for (int i = 1; i <= 40; ++i) {
    const Link slow{ms(0), ms(90), ms(120)};
    slow.pose(map, Time{} + ms(50 * i));
    slow.keyframe(map, Time{} + ms(50 * i));
  }
  EXPECT_EQ(map.clientTime(Time{} + ms(5000)), Time{} + ms(4910));
  EXPECT_EQ(map.sendBy(Time{} + ms(5000)), Time{} + ms(4880));
}

TEST(ClockMap, LeavesAnOutageOutOfTheLatency) {
  const Link link{ms(0), ms(10), ms(40)};
  ClockMap map;
  link.pose(map, Time{});
  for (int i = 0; i < 30; ++i) link.keyframe(map, Time{} + ms(200 * i), i == 15 ? ms(4000) : ms(0));
  EXPECT_GE(map.sendBy(Time{} + ms(9000)), Time{} + ms(9000 - 1000));
}

}  // namespace
}  // namespace foreland::server
