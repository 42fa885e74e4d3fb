// Bytes on a simulated link: they arrive when messages of the virtual world would, in order, whatever the link.
#include "lab/proxy/link_stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/support/seed.h"

namespace foreland::lab {
namespace {

sim::LinkOptions anyLink(Rng& rng) {
  sim::LinkOptions o;
  o.latency = Duration{static_cast<int64_t>(rng.below(200'000))};
  o.jitter = Duration{static_cast<int64_t>(rng.below(2) * rng.below(100'000))};
  o.bytes_per_second = rng.below(3) == 0 ? 0 : rng.uniform(2000, 2e6);
  o.queue_bytes = rng.below(2) * rng.below(100'000);
  o.loss = rng.below(2) == 0 ? 0 : rng.uniform(0, 0.3);
  o.repeat_after = Duration{static_cast<int64_t>(rng.below(200'000))};
  if (rng.below(2) == 0) o.stall_every = Duration::seconds(2), o.stall = Duration::milliseconds(300);
  if (rng.below(4) == 0)
    o.trace = std::make_shared<const sim::LinkTrace>(sim::LinkTrace::parse("3\n3\n40\n", "t").value());
  return o;
}

// What a sender has ready at times of its own, and what the receiver got when; the clock stands at no time but those
// that the stream or the sender name, as the proxy's does.
struct Carried {
  Bytes sent, received;
  std::vector<Time> due, got;  // of each byte: by a plain link of the same seed; in truth
  bool is_over = false;
};

Carried carry(const sim::LinkOptions& options, uint64_t seed, Rng& rng) {
  LinkStream stream(options, seed);
  sim::Link plain(options, seed);
  Carried all;
  Time now, next_send;
  size_t ready = 0, to_send = 30;
  while (!stream.isOver()) {
    for (; to_send > 0 && next_send <= now; --to_send)
      ready += 1 + rng.below(6000), next_send = now + Duration{static_cast<int64_t>(1 + rng.below(50'000))};
    const Bytes bytes = stream.arrived(now);
    all.received.insert(all.received.end(), bytes.begin(), bytes.end());
    all.got.resize(all.received.size(), now);
    while (ready > 0 && stream.mayRead(now)) {
      const size_t size = std::min(ready, 1 + rng.below(stream.pieceBytes()));
      Bytes piece(size);
      for (uint8_t& byte : piece) byte = static_cast<uint8_t>(rng.next());
      all.sent.insert(all.sent.end(), piece.begin(), piece.end());
      EXPECT_LE(plain.drainedAt(), now) << "the plain link's sender would still wait";
      plain.send(piece, now);
      all.due.resize(all.sent.size(), *plain.newestArrival());
      stream.take(std::move(piece), now);
      ready -= size;
    }
    if (ready == 0 && to_send == 0) stream.end(now);
    auto next = stream.nextChange(now);
    if (to_send > 0) next = next ? std::min(*next, next_send) : next_send;
    if (!next) break;
    EXPECT_GT(*next, now);
    now = *next;
  }
  all.is_over = stream.isOver();
  return all;
}

TEST(LinkStream, DeliversEachByteWhenThePlainLinkWould) {
  Rng rng(test::randomSeed());
  for (int round = 0; round < 20; ++round) {
    const sim::LinkOptions options = anyLink(rng);
    const Carried all = carry(options, rng.next(), rng);
    ASSERT_EQ(all.sent.size(), all.received.size());
    EXPECT_EQ(all.sent, all.received);
    EXPECT_EQ(all.due, all.got);
    EXPECT_TRUE(all.is_over);
  }
}

TEST(LinkStream, EndsBehindAllThatIsOnTheWay) {
  sim::LinkOptions slow;
  slow.bytes_per_second = 1000;
  LinkStream stream(slow, 1);
  stream.take(Bytes(500, 7), Time{});
  stream.end(Time{});
  EXPECT_FALSE(stream.mayRead(Time::seconds(9)));
  EXPECT_EQ(stream.nextChange(Time{}), Time::seconds(0.52));
  EXPECT_TRUE(stream.arrived(Time::seconds(0.519)).empty());
  EXPECT_FALSE(stream.isOver());
  EXPECT_EQ(stream.arrived(Time::seconds(0.52)), Bytes(500, 7));
  EXPECT_TRUE(stream.isOver());
  EXPECT_FALSE(stream.nextChange(Time::seconds(0.52)));
}

TEST(LinkStream, ReadsOnAsSoonAsItsSenderIsRidOfAllBefore) {
  sim::LinkOptions slow;
  slow.bytes_per_second = 1000;
  slow.latency = Duration::milliseconds(500);
  LinkStream stream(slow, 1);
  stream.take(Bytes(500), Time{});
  EXPECT_FALSE(stream.mayRead(Time::seconds(0.499)));
  EXPECT_EQ(stream.nextChange(Time{}), Time::seconds(0.5));
  EXPECT_TRUE(stream.mayRead(Time::seconds(0.5)));
  EXPECT_EQ(stream.nextChange(Time::seconds(0.5)), Time::seconds(1));
}

// A receiver that does not fetch holds the sender up, so that memory is bounded where no rate does it.
TEST(LinkStream, ReadsNoMoreThanItHolds) {
  LinkStream stream(sim::LinkOptions{}, 1);
  size_t taken = 0;
  for (; stream.mayRead(Time{}); taken += stream.pieceBytes()) stream.take(Bytes(stream.pieceBytes()), Time{});
  EXPECT_EQ(taken, LinkStream::kMaxBytes);
  EXPECT_EQ(stream.arrived(Time::seconds(1)).size(), taken);
  EXPECT_TRUE(stream.mayRead(Time::seconds(1)));
}

TEST(LinkStream, CutsPiecesThatHoldTheNextOnesUpForTenMilliseconds) {
  sim::LinkOptions options;
  EXPECT_EQ(LinkStream(options, 1).pieceBytes(), 64u << 10);
  options.bytes_per_second = 1e6;
  EXPECT_EQ(LinkStream(options, 1).pieceBytes(), 10'000u);
  options.bytes_per_second = 32'000;
  EXPECT_EQ(LinkStream(options, 1).pieceBytes(), sim::LinkTrace::kPacketBytes);  // no less than a packet
}

}  // namespace
}  // namespace foreland::lab
