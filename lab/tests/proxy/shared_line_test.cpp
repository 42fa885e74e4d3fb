// A link that several connections share carries what they send as one link carries all of it.
#include "lab/proxy/shared_line.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/support/seed.h"

namespace foreland::lab {
namespace {

TEST(SharedLine, CarriesWhatAllSendAsOneLinkDoes) {
  Rng rng(test::randomSeed());
  for (int trial = 0; trial < 50; ++trial) {
    sim::LinkOptions options;
    options.latency = Duration{static_cast<int64_t>(rng.below(200'000))};
    options.jitter = Duration{static_cast<int64_t>(rng.below(2) * rng.below(50'000))};
    options.bytes_per_second = rng.uniform(2000, 2e6);
    options.queue_bytes = rng.below(2) * rng.below(100'000);
    const uint64_t seed = rng.next();
    sim::Link alone(options, seed);
    const sim::LinkOptions shared = sharedByAll(options, seed);
    std::vector<sim::Link> all;
    for (uint64_t i = 0; i < 3; ++i) all.emplace_back(shared, rng.next());
    Time now;
    for (int message = 0; message < 100; ++message) {
      now = now + Duration{static_cast<int64_t>(rng.below(40'000))};
      sim::Link& one = all[rng.below(all.size())];
      const Bytes bytes(1 + rng.below(6000));
      alone.send(bytes, now);
      one.send(bytes, now);
      EXPECT_EQ(*one.newestArrival(), *alone.newestArrival());
      EXPECT_EQ(std::max(now, one.drainedAt()), std::max(now, alone.drainedAt()));
    }
  }
}

}  // namespace
}  // namespace foreland::lab
