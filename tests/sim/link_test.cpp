// Links in virtual time: order, rates, queues, losses, and recorded traces.
#include "sim/link.h"

#include <gtest/gtest.h>

#include <vector>

#include "sim/link_models.h"
#include "tests/support/seed.h"

namespace foreland::sim {
namespace {

LinkOptions anyLink(Rng& rng) {
  LinkOptions o;
  o.latency = Duration{static_cast<int64_t>(rng.below(300'000))};
  o.jitter = Duration{static_cast<int64_t>(rng.below(100'000))};
  o.bytes_per_second = rng.below(3) == 0 ? 0 : rng.uniform(1000, 1e6);
  o.queue_bytes = rng.below(2) == 0 ? 0 : rng.below(100'000);
  o.loss = rng.below(2) == 0 ? 0 : rng.uniform(0, 0.3);
  o.repeat_after = Duration{static_cast<int64_t>(rng.below(200'000))};
  if (rng.below(2) == 0) o.stall_every = Duration::seconds(5), o.stall = Duration::milliseconds(300);
  return o;
}

// What arrives when: of a hundred messages handed over at random times.
struct Sent {
  Time at, drained, arrival;
};
std::vector<Sent> flow(const LinkOptions& options, uint64_t seed) {
  Link link(options, seed);
  Rng rng(seed + 1);
  std::vector<Sent> all;
  Time now;
  for (uint8_t i = 0; i < 100; ++i) {
    now = now + Duration{static_cast<int64_t>(rng.below(200'000))};
    link.send(Bytes(1 + rng.below(20'000), i), now);
    all.push_back({now, link.drainedAt(), {}});
  }
  for (uint8_t i = 0; i < 100; ++i) {
    all[i].arrival = *link.nextArrival();
    EXPECT_EQ(link.receive().front(), i) << "messages change their order";
  }
  return all;
}

TEST(Link, KeepsTheOrderAndNeverLeadsItsLatency) {
  Rng rng(test::randomSeed());
  for (int round = 0; round < 50; ++round) {
    const LinkOptions options = anyLink(rng);
    const std::vector<Sent> all = flow(options, rng.next());
    for (size_t i = 0; i < all.size(); ++i) {
      EXPECT_GE(all[i].arrival, all[i].at + options.latency);
      EXPECT_GE(all[i].drained, all[i].at);
      EXPECT_LE(all[i].drained, all[i].arrival);
      if (i == 0) continue;
      EXPECT_GE(all[i].arrival, all[i - 1].arrival);
      EXPECT_GE(all[i].drained, all[i - 1].drained);
    }
  }
}

TEST(Link, GivesTheSameArrivalsForTheSameSeed) {
  LinkOptions lossy;
  lossy.loss = 0.1;
  lossy.repeat_after = Duration::milliseconds(80);
  const auto arrivals = [&](uint64_t seed) {
    std::vector<Time> times;
    for (const Sent& sent : flow(lossy, seed)) times.push_back(sent.arrival);
    return times;
  };
  EXPECT_EQ(arrivals(3), arrivals(3));
  EXPECT_NE(arrivals(3), arrivals(4));
}

TEST(Link, TakesWhatFitsItsQueueOffTheSender) {
  LinkOptions slow;
  slow.bytes_per_second = 10'000;
  slow.queue_bytes = 15'000;
  Link link(slow, 1);
  link.send(Bytes(10'000), Time{});
  EXPECT_EQ(link.drainedAt(), Time{});  // it fits
  link.send(Bytes(10'000), Time{});
  EXPECT_EQ(link.drainedAt(), Time::seconds(0.5));  // when 15,000 of 20,000 bytes are left
  EXPECT_EQ(link.unsentBytes(Time{}), 10'000u);
}

TEST(LinkModels, AreFoundByName) {
  for (const LinkModel& model : linkModels()) {
    ASSERT_TRUE(linkNamed(model.name).ok()) << model.name;
    EXPECT_GT(std::string(model.source).size(), 20u) << model.name;
  }
  const auto wrong = linkNamed("pigeon");
  ASSERT_FALSE(wrong.ok());
  EXPECT_NE(wrong.error().message.find("'pigeon'"), std::string::npos);
  EXPECT_NE(wrong.error().message.find("starlink"), std::string::npos);
}

TEST(LinkModels, SplitTheRoundTripEvenly) {
  const LinkPair pair = fixedLink(Duration::milliseconds(200));
  EXPECT_EQ(pair.up.latency, Duration::milliseconds(100));
  EXPECT_EQ(pair.down.latency, Duration::milliseconds(100));
}

TEST(LinkTrace, CarriesByteForByteWhatItsLinesAllow) {
  const auto trace = LinkTrace::parse("10\n10\n30\n", "t");
  ASSERT_TRUE(trace.ok()) << trace.error().message;
  LinkTrace::Position at;
  EXPECT_EQ(trace->transmit(1000, Time{0}, at), Time{10'000});
  EXPECT_EQ(trace->transmit(500, Time{0}, at), Time{10'000});      // the rest of the first line
  EXPECT_EQ(trace->transmit(1600, Time{0}, at), Time{30'000});     // the second, and a part of the third
  EXPECT_EQ(trace->transmit(1400, Time{0}, at), Time{30'000});     // its rest
  EXPECT_EQ(trace->transmit(1, Time{0}, at), Time{40'000});        // the next round begins at 30 ms
  EXPECT_EQ(trace->transmit(1, Time{95'000}, at), Time{100'000});  // what nobody used is lost
  EXPECT_NEAR(trace->bytesPerSecond(), 150'000, 1e-6);
}

// Against a plain list of all bytes that could be carried.
TEST(LinkTrace, AgreesWithAListOfOpportunities) {
  Rng rng(test::randomSeed());
  for (int round = 0; round < 50; ++round) {
    std::string text;
    std::vector<int64_t> lines;
    int64_t ms = static_cast<int64_t>(rng.below(3));
    for (uint64_t i = 1 + rng.below(8); i-- > 0; ms += static_cast<int64_t>(rng.below(4))) lines.push_back(ms);
    lines.push_back(ms + 1);
    for (const int64_t line : lines) text += std::to_string(line) + "\n";
    const auto trace = LinkTrace::parse(text, "t");
    ASSERT_TRUE(trace.ok()) << trace.error().message;
    std::vector<int64_t> all;  // of many rounds
    for (int64_t r = 0; r < 200; ++r)
      for (const int64_t line : lines) all.push_back(r * lines.back() + line);
    LinkTrace::Position at;
    size_t next = 0, left = LinkTrace::kPacketBytes;
    Time now;
    for (int i = 0; i < 20; ++i) {
      now = now + Duration{static_cast<int64_t>(rng.below(9000))};
      size_t bytes = 1 + rng.below(4000);
      const Time carried = trace->transmit(bytes, now, at);
      while (all[next] * 1000 < now.us) ++next, left = LinkTrace::kPacketBytes;
      while (bytes > left) bytes -= left, ++next, left = LinkTrace::kPacketBytes;
      left -= bytes;
      ASSERT_EQ(carried, Time{std::max(now.us, all[next] * 1000)}) << text;
      if (left == 0) ++next, left = LinkTrace::kPacketBytes;
    }
  }
}

TEST(LinkTrace, RefusesBrokenFilesByLine) {
  const auto refusal = [](const char* text) {
    const auto trace = LinkTrace::parse(text, "up.trace");
    return trace.ok() ? std::string("taken") : trace.error().message;
  };
  EXPECT_EQ(refusal(""), "up.trace:0: the trace has no line");
  EXPECT_EQ(refusal("1\nx\n"), "up.trace:2: 'x' is not a time in whole milliseconds");
  EXPECT_EQ(refusal("1.5\n"), "up.trace:1: '1.5' is not a time in whole milliseconds");
  EXPECT_EQ(refusal("-3\n"), "up.trace:1: '-3' is not a time in whole milliseconds");
  EXPECT_EQ(refusal("99999999999\n"), "up.trace:1: '99999999999' is not a time in whole milliseconds");
  EXPECT_EQ(refusal("5\n4\n"), "up.trace:2: the time 4 ms is before the one above it");
  EXPECT_EQ(refusal("0\n0\n"), "up.trace:2: the trace ends at 0 ms, so its rate is not known");
  EXPECT_EQ(refusal("1\r\n2\r\n"), "taken");
  EXPECT_FALSE(LinkTrace::read("/nowhere/up.trace").ok());
}

}  // namespace
}  // namespace foreland::sim
