// Reads of simulated stores, in virtual time: what is under way comes soon, however slow the store is, and no store is
// used much less than by reads that are as long and as many as they may be.
#include "terrain/store/distant/read_pace.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::test {
namespace {

using terrain::ReadPace;

constexpr uint64_t kChunk = 65536;
constexpr size_t kThreads = 8;

// A line that reads share evenly. Each of them waits first, and is no quicker than its connection.
struct Store {
  double bytes_per_second = 0, of_each = std::numeric_limits<double>::infinity();
  double latency_s = 0;

  double chunk_s() const { return latency_s + kChunk / std::min(bytes_per_second, of_each); }
  // In which several reads of a chunk come.
  double while_s() const { return std::max(1.0, chunk_s()); }
};

Store storeOfChance(Rng& rng) {
  Store store;
  store.bytes_per_second = 6e4 * std::pow(2000, rng.uniform());  // half a Mbit/s to one Gbit/s
  store.latency_s = rng.uniform(0.005, 0.15);
  if (rng.below(2)) store.of_each = 1e5 * std::pow(1000, rng.uniform());
  return store;
}

// Threads that always have something to read: without a pace, as much at a time as they may.
class Readers {
 public:
  explicit Readers(bool has_pace) {
    if (has_pace) pace_.emplace(kChunk);
  }

  // Reads a chunk alone, as when a scene is opened.
  void open(const Store& store) {
    const ReadPace::Read read = pace_->begin(kChunk, now());
    now_s_ += store.chunk_s();
    pace_->end(read, true, now());
  }
  // The bytes that come in some time.
  double run(const Store& store, double seconds) {
    constexpr double kStep_s = 0.002;
    const double came_before = came_;
    for (double t = 0; t < seconds; t += kStep_s) {
      beginAll(store);
      now_s_ += kStep_s;
      const auto active = std::ranges::count_if(reads_, [](const Read& read) { return read.wait_s <= 0; });
      const double of_each = std::min(store.of_each, store.bytes_per_second / static_cast<double>(active));
      for (Read& read : reads_)
        (read.wait_s > 0 ? read.wait_s : read.left) -= kStep_s * (read.wait_s > 0 ? 1 : of_each);
      std::erase_if(reads_, [&](const Read& read) { return read.left <= 0 && end(read); });
    }
    return came_ - came_before;
  }
  // Of the reads that ended since the last call: the longest time; and the most chunks of those that began.
  double takeLongest() { return std::exchange(longest_s_, 0); }
  size_t takeMostChunks() { return std::exchange(most_chunks_, 0); }

 private:
  struct Read {
    double wait_s, left, bytes, begun_s;
    ReadPace::Read paced;
  };

  Time now() const { return Time::seconds(now_s_); }
  void beginAll(const Store& store) {
    while (reads_.size() < kThreads) {
      const size_t chunks = pace_ ? pace_->chunks() : ReadPace::kMostChunks;
      if (chunks == 0) return;
      most_chunks_ = std::max(most_chunks_, chunks);
      const uint64_t bytes = kChunk * chunks;
      const auto count = static_cast<double>(bytes);
      reads_.push_back({store.latency_s, count, count, now_s_, pace_ ? pace_->begin(bytes, now()) : ReadPace::Read{}});
    }
  }
  bool end(const Read& read) {
    if (pace_) pace_->end(read.paced, true, now());
    came_ += read.bytes;
    longest_s_ = std::max(longest_s_, now_s_ - read.begun_s);
    return true;
  }

  std::optional<ReadPace> pace_;
  std::vector<Read> reads_;
  double now_s_ = 1, came_ = 0, longest_s_ = 0;
  size_t most_chunks_ = 0;
};

TEST(ReadPace, LetsNobodyWaitLongForASlowStoreAndUsesItWell) {
  Rng rng(randomSeed());
  for (int i = 0; i < 20; ++i) {
    const Store store = storeOfChance(rng);
    SCOPED_TRACE(testing::Message() << store.bytes_per_second << " B/s, of each " << store.of_each << ", "
                                    << store.latency_s << " s");
    Readers paced(true), unpaced(false);
    paced.open(store);
    paced.run(store, 10 * store.while_s());
    (void)paced.takeLongest();
    constexpr double kAll = kThreads * ReadPace::kMostBytes;  // bytes
    const double seconds = 20 * store.while_s(), all_s = kAll / store.bytes_per_second;
    const double came = paced.run(store, seconds);
    EXPECT_LT(paced.takeLongest(), 3 * store.while_s());
    unpaced.run(store, 10 + 5 * all_s);
    const double long_s = std::max(seconds, 20 * all_s);
    EXPECT_GT(came / seconds, 0.7 * unpaced.run(store, long_s) / long_s);
  }
}

TEST(ReadPace, FollowsAStoreThatGetsSlowAndQuickAgain) {
  const Store quick{.bytes_per_second = 1e8, .latency_s = 0.01}, slow{.bytes_per_second = 125'000, .latency_s = 0.1};
  Readers readers(true);
  readers.open(quick);
  readers.run(quick, 10);
  EXPECT_EQ(readers.takeMostChunks(), ReadPace::kMostChunks);
  readers.run(slow, 80);  // in which all comes that was under way, of eight reads of 1 MiB
  (void)readers.takeLongest();
  (void)readers.takeMostChunks();
  readers.run(slow, 60);
  EXPECT_LT(readers.takeLongest(), 3);
  EXPECT_EQ(readers.takeMostChunks(), 1u);
  readers.run(quick, 10);
  EXPECT_EQ(readers.takeMostChunks(), ReadPace::kMostChunks);
}

TEST(ReadPace, LearnsNothingFromReadsThatFail) {
  ReadPace pace(kChunk);
  EXPECT_EQ(pace.chunks(), ReadPace::kMostChunks);
  pace.end(pace.begin(kChunk, Time::seconds(1)), false, Time::seconds(11));
  EXPECT_EQ(pace.chunks(), ReadPace::kMostChunks);
  EXPECT_EQ(pace.bytesPerSecond(), 0);
  pace.end(pace.begin(kChunk, Time::seconds(11)), true, Time::seconds(12));
  EXPECT_DOUBLE_EQ(pace.bytesPerSecond(), kChunk);
}

}  // namespace
}  // namespace foreland::test
