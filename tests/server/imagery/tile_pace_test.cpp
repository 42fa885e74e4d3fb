// The pace of tiles, on a link that transmits so many bytes a second and keeps what waits in order.
#include "server/imagery/tile_pace.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::server {
namespace {

struct Outcome {
  double bytes_per_second;  // of tiles, in the second half
  Duration p95_queued;      // keyframes, in the second half: later than on an empty link
  Duration max_queued;      // of all keyframes
};

// A minute of keyframes every 200 ms and, always, tiles that wait.
Outcome run(double link_bytes_per_second, uint32_t limit, Rng& rng, double first_bytes = 3000) {
  constexpr Duration kInterval = Duration::milliseconds(200), kLatency = Duration::milliseconds(25),
                     kOffset = Duration::seconds(-1234);
  TilePace pace;
  Time free;  // when the link has transmitted all
  const auto transmit = [&](Time now, double bytes) {
    free = std::max(free, now) + Duration::seconds(bytes / link_bytes_per_second);
    return free;
  };
  double tiles = 0;
  std::vector<Duration> queued;
  Duration max_queued;
  const Time end = Time::seconds(60), half = Time::seconds(30);
  struct Arrival {
    Time at, arrived_client;
    uint32_t index;
    Duration round_trip;
  };
  uint32_t index = 0;
  std::vector<Arrival> acknowledged;
  for (Time now = Time::seconds(1); now < end; now = now + kInterval) {
    const double bytes = index == 0 ? first_bytes : rng.uniform(300, 3000);
    const Duration jitter{static_cast<int64_t>(rng.below(4000))};
    const Time arrived = transmit(now, bytes) + kLatency + jitter;
    const Duration waited = arrived - now - kLatency - Duration::seconds(bytes / link_bytes_per_second);
    if (now > half) queued.push_back(waited);
    max_queued = std::max(max_queued, waited);
    acknowledged.push_back({arrived + kLatency, arrived + kOffset, ++index, arrived + kLatency - now});
    while (!acknowledged.empty() && acknowledged.front().at <= now) {
      pace.keyframeArrived(acknowledged.front().index, acknowledged.front().arrived_client,
                           acknowledged.front().round_trip);
      acknowledged.erase(acknowledged.begin());
    }
    pace.keyframeSent(index, static_cast<size_t>(bytes), now, kInterval.toSeconds(), limit);
    while (pace.mayBeSent()) {
      const auto tile = static_cast<size_t>(rng.uniform(2000, 30000));
      pace.sent(tile);
      transmit(now, static_cast<double>(tile));
      if (now > half) tiles += static_cast<double>(tile);
    }
  }
  std::sort(queued.begin(), queued.end());
  return {tiles / 30, queued[queued.size() * 95 / 100], max_queued};
}

TEST(TilePace, UsesTheLinkAndDoesNotDelayKeyframes) {
  Rng rng(test::randomSeed());
  for (const double mbit : {0.5, 2.0, 10.0, 100.0}) {
    const double rate = mbit * 125e3;
    const Outcome outcome = run(rate, 0, rng);
    EXPECT_LE(outcome.bytes_per_second, rate) << mbit;
    EXPECT_GE(outcome.bytes_per_second, 0.4 * rate) << mbit;
    // One tile of 30 kB may be on the link when a keyframe comes.
    EXPECT_LE(outcome.p95_queued.toMilliseconds(), 80 + 30000 / rate * 1e3) << mbit;
  }
}

// The first keyframe takes 2 s at 0.25 Mbit/s; the next ones wait for it, and for one interval's share of tiles.
TEST(TilePace, BeginsSlowlyOnALinkThatTheFirstKeyframeFills) {
  Rng rng(test::randomSeed());
  const Outcome outcome = run(31'250, 0, rng, 62'500);
  EXPECT_LE(outcome.max_queued.toMilliseconds(), 2000 + 2500);
  EXPECT_GE(outcome.bytes_per_second, 12e3);
}

struct Waiting {
  double bytes_per_second;  // of tiles
  Duration p95_late;        // keyframes, which wait until all has been sent
};

// A minute of keyframes of so many bytes and, but for some seconds, tiles that wait; the first one is large. The
// transport has no queue but its own, so a keyframe is not given to it before it has sent all. Everything takes
// `overhead` before it is sent.
Waiting runWaiting(double link_bytes_per_second, double max_bytes, Duration overhead, Rng& rng) {
  constexpr Duration kInterval = Duration::milliseconds(200), kLatency = Duration::milliseconds(25);
  TilePace pace;
  double tiles = 0;
  std::vector<Duration> late;
  Time due = Time::seconds(1), sent = due, arrived;
  for (uint32_t index = 1; index < 300; ++index, due = due + kInterval) {
    const Time now = std::max(due, sent);
    pace.drained(sent);
    if (index > 1) pace.keyframeArrived(index - 1, arrived, kLatency * 2);
    double bytes = index == 1 ? 100e3 : rng.uniform(0.1 * max_bytes, max_bytes);
    arrived = now + overhead + Duration::seconds(bytes / link_bytes_per_second) + kLatency;
    pace.keyframeSent(index, static_cast<size_t>(bytes), now, kInterval.toSeconds(), 0);
    const bool has_tiles = index < 50 || index >= 80;
    while (has_tiles && pace.mayBeSent()) {
      const auto tile = static_cast<size_t>(rng.uniform(2000, 12000));
      pace.sent(tile);
      bytes += static_cast<double>(tile);
      if (index >= 100) tiles += static_cast<double>(tile);
    }
    pace.given(now);
    sent = now + overhead + Duration::seconds(bytes / link_bytes_per_second);
    if (index >= 100) late.push_back(now - due);
    due = std::max(due, now - kInterval);  // those that are too late are left out
  }
  std::sort(late.begin(), late.end());
  return {tiles / 40, late[late.size() * 95 / 100]};
}

TEST(TilePace, LeavesRoomForTheNextKeyframeWhereItWaitsForAllToBeSent) {
  Rng rng(test::randomSeed());
  for (const double mbit : {0.5, 1.0, 4.0, 100.0}) {
    const double rate = mbit * 125e3;
    const Waiting outcome = runWaiting(rate, 3000, {}, rng);
    EXPECT_GE(outcome.bytes_per_second, 0.4 * rate) << mbit;
    // One tile too much of 12 kB.
    EXPECT_LE(outcome.p95_late.toMilliseconds(), 30 + 12000 / rate * 1e3) << mbit;
  }
}

// However small its keyframes are, which then take as long as large ones; and if each is late, tiles go on.
TEST(TilePace, DoesNotTakeAServerThatIsBusyForASlowLink) {
  Rng rng(test::randomSeed());
  for (const auto& [overhead_ms, least] : {std::pair{10, 375e3}, {40, 375e3}, {80, 375e3}, {250, 15e3}}) {
    const Waiting outcome = runWaiting(1.25e6, 100, Duration::milliseconds(overhead_ms), rng);
    EXPECT_GE(outcome.bytes_per_second, least) << overhead_ms;
  }
}

TEST(TilePace, TakesAtMostHalfOfWhatTheViewerAllows) {
  Rng rng(test::randomSeed());
  const Outcome outcome = run(125e6, 100'000, rng);
  EXPECT_LE(outcome.bytes_per_second, 55'000);
  EXPECT_GE(outcome.bytes_per_second, 40'000);
}

TEST(TilePace, WhatIsNotUsedDoesNotAddUp) {
  TilePace pace;
  for (uint32_t i = 1; i < 100; ++i) {
    const Time now = Time::seconds(0.2 * i);
    pace.keyframeSent(i, 1000, now, 0.2, 0);
    pace.keyframeArrived(i, now, Duration::milliseconds(50));
  }
  size_t sent = 0;
  for (; pace.mayBeSent(); sent += 1000) pace.sent(1000);
  EXPECT_LE(static_cast<double>(sent), 0.2 * pace.bytesPerSecond() + 1000);
}

}  // namespace
}  // namespace foreland::server
