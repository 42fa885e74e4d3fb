// The part of a distant file that is here: what is held is what the file has, whatever the store does; no more is there
// than may be; and the longest unused makes room.
#include "terrain/store/distant/chunk_cache.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <barrier>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/rng.h"
#include "tests/support/far_store.h"
#include "tests/support/seed.h"

namespace foreland::test {
namespace {

using terrain::ChunkCache;
using terrain::SceneSums;
using Mood = FarStore::Mood;

constexpr uint64_t kChunk = SceneSums::kLeastChunk;

// A file of chance, with a last chunk that is short.
struct FarFile {
  std::vector<char> bytes;
  std::shared_ptr<FarStore> store;
  std::shared_ptr<ChunkCache> cache;
  TemporaryFolder folder;

  FarFile(uint64_t seed, uint32_t chunks, uint32_t capacity) {
    Rng rng(seed);
    bytes.resize(chunks * kChunk - kChunk / 2);
    for (char& byte : bytes) byte = static_cast<char>(rng.below(256));
    spit(folder / "file", bytes);
    store = std::make_shared<FarStore>(bytes);
    auto sums = terrain::sumsOf(folder / "file", kChunk);
    CHECK_TRUE(sums.ok());
    auto made = ChunkCache::create(std::move(*sums), store,
                                   {.cache_bytes = capacity * kChunk, .folder = folder.path(), .now = {}});
    CHECK_TRUE(made.ok());
    cache = *made;
  }
  bool isTrue(ChunkCache::Chunk chunk) const {
    const uint64_t begin = cache->sums().begin(chunk), count = cache->sums().bytesOf(chunk);
    return std::equal(bytes.begin() + static_cast<std::ptrdiff_t>(begin),
                      bytes.begin() + static_cast<std::ptrdiff_t>(begin + count), cache->file().data() + begin,
                      [](char a, uint8_t b) { return static_cast<uint8_t>(a) == b; });
  }
  bool isThere(ChunkCache::Chunk chunk) const {
    if (!cache->hold(chunk)) return false;
    cache->release(chunk);
    return true;
  }
};

TEST(ChunkCache, HoldsWhatTheFileHasWhateverTheStoreDoes) {
  const uint64_t seed = randomSeed();
  constexpr uint32_t kChunks = 60, kCapacity = 12;
  const FarFile file(seed, kChunks, kCapacity);
  ChunkCache& cache = *file.cache;
  ChunkCache::Wishes wishes(cache);
  Rng rng(seed);
  std::vector<ChunkCache::Chunk> held;
  uint64_t uses = cache.counts().uses;
  for (int i = 0; i < 2000; ++i) {
    file.store->mood = rng.below(2) ? Mood::kSound : static_cast<Mood>(rng.below(4));
    std::vector<ChunkCache::Wish> some;
    for (uint64_t k = rng.below(6); k > 0; --k)
      some.push_back({static_cast<uint32_t>(rng.below(kChunks)), static_cast<float>(rng.uniform(0, 9))});
    wishes.set(some);
    for (uint64_t k = rng.below(3); k > 0; --k) (void)cache.fetch();
    const auto chunk = static_cast<ChunkCache::Chunk>(rng.below(kChunks));
    if (cache.hold(chunk)) held.push_back(chunk), ++uses;
    if (held.size() > 6) {
      const size_t one = rng.below(held.size());
      cache.release(held[one]);
      held.erase(held.begin() + static_cast<std::ptrdiff_t>(one));
    }
    for (const ChunkCache::Chunk each : held) ASSERT_TRUE(file.isTrue(each)) << each;
    ASSERT_LE(cache.counts().there, kCapacity);
  }
  EXPECT_EQ(cache.counts().uses, uses);
  EXPECT_GT(cache.counts().evicted, 100u);
  EXPECT_GT(cache.counts().unsound, 10u);
  EXPECT_GT(cache.counts().failed, 10u);
  for (const ChunkCache::Chunk each : held) cache.release(each);
}

TEST(ChunkCache, LetsTheLongestUnusedMakeRoom) {
  const FarFile file(1, 40, 8);
  ChunkCache& cache = *file.cache;
  ChunkCache::Wishes wishes(cache);
  const auto bring = [&](ChunkCache::Chunk chunk) {
    wishes.set({{chunk, 1}});
    ASSERT_TRUE(cache.fetch());
  };
  for (ChunkCache::Chunk chunk = 0; chunk < 16; chunk += 2) bring(chunk);
  ASSERT_TRUE(cache.hold(2));    // is held, though it is old
  EXPECT_TRUE(file.isThere(0));  // was just used
  for (const ChunkCache::Chunk chunk : {20, 22}) bring(static_cast<ChunkCache::Chunk>(chunk));
  for (const int there : {0, 2, 8, 10, 12, 14, 20, 22})
    EXPECT_TRUE(file.isThere(static_cast<uint32_t>(there))) << there;
  for (const int gone : {4, 6}) EXPECT_FALSE(file.isThere(static_cast<uint32_t>(gone))) << gone;
  cache.release(2);
}

TEST(ChunkCache, FetchesTheLargestErrorFirstAndItsNeighboursWithIt) {
  const FarFile file(2, 40, 20);
  ChunkCache::Wishes mine(*file.cache), others(*file.cache);
  mine.set({{5, 2}, {30, 1}, {31, 7}, {32, 1}});
  others.set({{6, 1}, {9, 3}});
  ASSERT_TRUE(file.cache->fetch());
  EXPECT_EQ(file.store->reads, 1u);
  for (const uint32_t there : {30u, 31u, 32u}) EXPECT_TRUE(file.isThere(there));
  EXPECT_EQ(file.cache->counts().there, 3u);
  ASSERT_TRUE(file.cache->fetch());
  EXPECT_TRUE(file.isThere(9));
}

TEST(ChunkCache, FetchesNothingWhileAllThatIsThereIsHeld) {
  const FarFile file(3, 20, 2);
  ChunkCache& cache = *file.cache;
  ChunkCache::Wishes wishes(cache);
  wishes.set({{3, 1}, {4, 1}});
  ASSERT_TRUE(cache.fetch());
  ASSERT_TRUE(cache.hold(3) && cache.hold(4));
  wishes.set({});
  ChunkCache::Wishes others(cache);
  others.set({{9, 9}});
  EXPECT_FALSE(cache.fetch());
  EXPECT_EQ(file.store->reads, 1u);
  cache.release(3);
  others.set({{9, 9}});
  EXPECT_TRUE(cache.fetch());
  EXPECT_TRUE(file.isThere(9) && !file.isThere(3));
  cache.release(4);
}

TEST(ChunkCache, FetchesNothingTwiceForWishesThatDoNotFitTogether) {
  constexpr uint32_t kCapacity = 12, kEach = 10;
  const FarFile file(6, 60, kCapacity);
  ChunkCache& cache = *file.cache;
  ChunkCache::Wishes mine(cache), others(cache);
  std::vector<ChunkCache::Wish> near, far;
  for (uint32_t i = 0; i < kEach; ++i) near.push_back({2 * i, 3}), far.push_back({2 * i + 30, 2});
  mine.set(near);
  others.set(far);
  for (uint32_t i = 0; i < 10 * kCapacity && cache.fetch();) ++i;
  EXPECT_EQ(cache.counts().fetched, kCapacity);
  EXPECT_EQ(cache.counts().evicted, 0u);
  mine.set({});  // now it may go
  for (uint32_t i = 0; i < 10 * kCapacity && cache.fetch();) ++i;
  for (const ChunkCache::Wish& wish : far) EXPECT_TRUE(file.isThere(wish.chunk));
  EXPECT_LE(cache.counts().fetched, 2 * kEach + kCapacity);
}

TEST(ChunkCache, KeepsNoMoreThanHalfForGood) {
  const FarFile file(6, 40, 10);
  ASSERT_TRUE(file.cache->keep(kChunk + 5, 2 * kChunk).ok());
  for (const uint32_t there : {1u, 2u, 3u}) EXPECT_TRUE(file.isThere(there));
  EXPECT_EQ(file.store->reads, 1u);
  EXPECT_TRUE(file.cache->keep(39 * kChunk, 10).ok());
  const Status status = file.cache->keep(10 * kChunk, 6 * kChunk);
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().message.find("--store-cache-mib"), std::string::npos);
}

// A store that is silent is asked again later and later, and goes on at once when it answers.
TEST(ChunkCache, AsksADeadStoreLessAndLess) {
  const FarFile file(4, 20, 10);
  Time now;
  std::vector<std::string> told;
  auto made = ChunkCache::create(*terrain::sumsOf(file.folder / "file", kChunk), file.store,
                                 {.cache_bytes = 10 * kChunk,
                                  .folder = file.folder.path(),
                                  .now = [&] { return now; },
                                  .tell = [&](const std::string& what) { told.push_back(what); }});
  ASSERT_TRUE(made.ok());
  ChunkCache& cache = **made;
  ChunkCache::Wishes wishes(cache);
  wishes.set({{3, 1}, {8, 1}});
  file.store->mood = Mood::kDead;
  for (int ms = 0; ms < 60'000; ms += 10, now = now + Duration::milliseconds(10)) (void)cache.fetch();
  EXPECT_LT(file.store->reads, 25u);
  EXPECT_GT(file.store->reads, 10u);
  ASSERT_EQ(told.size(), 1u);
  file.store->mood = Mood::kSound;
  now = now + Duration::milliseconds(5000);
  EXPECT_TRUE(cache.fetch());
  EXPECT_EQ(told.back(), "the store answers again");
}

// A store that gives so many bytes a second, in virtual time.
class SlowStore final : public terrain::RangeSource {
 public:
  SlowStore(std::shared_ptr<FarStore> store, double bytes_per_second)
      : store_(std::move(store)), bytes_per_second_(bytes_per_second) {}
  Result<Bytes> read(uint64_t offset, uint64_t bytes) override {
    now = now + Duration::seconds(static_cast<double>(bytes) / bytes_per_second_);
    return store_->read(offset, bytes);
  }

  Time now;

 private:
  const std::shared_ptr<FarStore> store_;
  const double bytes_per_second_;
};

// How many chunks the first read brings after one chunk was kept, with all wished for.
uint64_t firstRun(double bytes_per_second) {
  const FarFile file(8, 60, 60);
  const auto store = std::make_shared<SlowStore>(file.store, bytes_per_second);
  auto made =
      ChunkCache::create(*terrain::sumsOf(file.folder / "file", kChunk), store,
                         {.cache_bytes = 60 * kChunk, .folder = file.folder.path(), .now = [&] { return store->now; }});
  CHECK_TRUE(made.ok());
  ChunkCache& cache = **made;
  CHECK_TRUE(cache.keep(0, 1).ok());
  EXPECT_NEAR(cache.bytesPerSecond(), bytes_per_second, 1e-3 * bytes_per_second);
  ChunkCache::Wishes wishes(cache);
  std::vector<ChunkCache::Wish> all;
  for (uint32_t chunk = 1; chunk < 60; ++chunk) all.push_back({chunk, 1});
  wishes.set(all);
  EXPECT_TRUE(cache.fetch());
  return cache.counts().fetched - 1;
}

TEST(ChunkCache, ReadsAsMuchAtATimeAsTheStoreGivesSoon) {
  EXPECT_EQ(firstRun(1e3), 1u);
  EXPECT_EQ(firstRun(4.096e6), terrain::ReadPace::kMostChunks);
  const uint64_t between = firstRun(1e5);
  EXPECT_GT(between, 1u);
  EXPECT_LT(static_cast<double>(between * kChunk), 1e5);
}

TEST(ChunkCache, OpensASceneFromASlowStoreSoon) {
  const TemporaryFolder folder;
  FormulaSource source(257, 257, hills(3));
  const auto path = folder / "scene.fls";
  ASSERT_TRUE(terrain::buildScene(source, {.output = path, .height_quantum_m = 0.1, .threads = 1}).ok());
  const Bytes sums = encode(*terrain::sumsOf(path, kChunk));
  const auto opened = [&](double bytes_per_second) {
    const auto store = std::make_shared<SlowStore>(std::make_shared<FarStore>(slurp(path)), bytes_per_second);
    const auto scene = terrain::openDistant(
        store, sums, "far",
        {.cache_bytes = uint64_t{1} << 30, .folder = folder.path(), .now = [&] { return store->now; }});
    CHECK_TRUE(scene.ok());
    return std::pair((*scene)->supply()->cache().counts().fetched_bytes, store->now.toSeconds());
  };
  const auto [all, quick_s] = opened(1e9);
  const auto [some, slow_s] = opened(2e4);
  EXPECT_GT(all, 500'000u);
  EXPECT_LT(some, all / 3);
  EXPECT_LT(slow_s, 9);
}

// Lets reads fail together: none ends before so many are under way.
class FailingTogether final : public terrain::RangeSource {
 public:
  FailingTogether(FarStore& store, int reads) : store_(store), all_(reads) {}
  Result<Bytes> read(uint64_t offset, uint64_t bytes) override {
    auto result = store_.read(offset, bytes);
    if (!result) all_.arrive_and_wait();
    return result;
  }

 private:
  FarStore& store_;
  std::barrier<> all_;
};

TEST(ChunkCache, TakesReadsThatFailTogetherForOneFailure) {
  constexpr int kReads = 4;
  const FarFile file(7, 40, 20);
  Time now;
  auto made = ChunkCache::create(
      *terrain::sumsOf(file.folder / "file", kChunk), std::make_shared<FailingTogether>(*file.store, kReads),
      {.cache_bytes = 20 * kChunk, .folder = file.folder.path(), .now = [&] { return now; }});
  ASSERT_TRUE(made.ok());
  ChunkCache& cache = **made;
  ChunkCache::Wishes wishes(cache);
  wishes.set({{3, 1}, {9, 1}, {15, 1}, {21, 1}});
  file.store->mood = Mood::kDead;
  std::vector<std::thread> threads;
  for (int i = 0; i < kReads; ++i) threads.emplace_back([&] { EXPECT_TRUE(cache.fetch()); });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(cache.counts().failed, uint64_t{kReads});
  EXPECT_FALSE(cache.fetch());
  file.store->mood = Mood::kSound;
  now = now + Duration::milliseconds(100);
  EXPECT_TRUE(cache.fetch());
}

TEST(ChunkCache, ServesReadersWhileThreadsFetch) {
  const uint64_t seed = randomSeed();
  constexpr uint32_t kChunks = 50;
  const FarFile file(seed, kChunks, 10);
  file.cache->start(3);
  std::vector<std::thread> readers;
  std::atomic<int> read{0}, wrong{0};
  for (uint32_t r = 0; r < 3; ++r)
    readers.emplace_back([&, r] {
      Rng rng(seed + r);
      ChunkCache::Wishes wishes(*file.cache);
      for (int seen = 0; seen < 60;) {
        const auto chunk = static_cast<ChunkCache::Chunk>(rng.below(kChunks));
        wishes.set({{chunk, 1}});
        while (!file.cache->hold(chunk)) std::this_thread::yield();
        wrong += file.isTrue(chunk) ? 0 : 1;
        file.cache->release(chunk);
        ++read, ++seen;
      }
    });
  for (std::thread& reader : readers) reader.join();
  EXPECT_EQ(read, 180);
  EXPECT_EQ(wrong, 0);
}

TEST(SceneSums, ComeBackFromTheirBytesAndNoneOfThemMayChange) {
  const FarFile file(5, 9, 4);
  const SceneSums& sums = file.cache->sums();
  Bytes bytes = encode(sums);
  const auto back = terrain::decodeSums(bytes, "sums");
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(back->sums, sums.sums);
  EXPECT_EQ(back->file_bytes, sums.file_bytes);
  for (size_t at = 0; at < bytes.size(); ++at) {
    bytes[at] ^= 4;
    EXPECT_FALSE(terrain::decodeSums(bytes, "sums").ok()) << at;
    bytes[at] ^= 4;
    EXPECT_FALSE(terrain::decodeSums(ByteSpan(bytes).first(at), "sums").ok()) << at;
  }
}

}  // namespace
}  // namespace foreland::test
