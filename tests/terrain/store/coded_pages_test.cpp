#include "terrain/store/coded/coded_pages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <thread>
#include <vector>

#include "base/rng.h"
#include "terrain/store/coded/group_codec.h"
#include "terrain/store/mapped_scene.h"
#include "terrain/store/verify.h"
#include "tests/support/files.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"
#include "tests/support/sparse_scene.h"

namespace foreland::terrain {
namespace {

// A scene twice: its pages as they are in memory, and coded.
class CodedScene : public testing::Test {
 protected:
  test::TemporaryFolder folder;

  // Wide enough for many groups, and not as wide as its roots.
  void build(proto::FrameKind kind = proto::FrameKind::kGeographic, uint32_t width = 300, uint32_t height = 260) {
    for (const auto coding : {PageCoding::kPlain, PageCoding::kCoded}) {
      test::FormulaSource source(width, height, test::hills(11), kind);
      ASSERT_TRUE(buildScene(source, {.output = path(coding), .additions = {.page_coding = coding}}).ok());
    }
  }
  std::filesystem::path path(PageCoding coding) const {
    return folder / (coding == PageCoding::kPlain ? "plain.fls" : "coded.fls");
  }
  std::shared_ptr<const MappedScene> open(PageCoding coding) const {
    auto scene = MappedScene::open(path(coding));
    EXPECT_TRUE(scene.ok()) << scene.error().message;
    return *scene;
  }
};

bool areEqual(std::span<const NodeRecord> a, std::span<const NodeRecord> b) { return std::ranges::equal(a, b); }

TEST_F(CodedScene, HasTheRecordsOfThePlainOne) {
  for (const auto kind : {proto::FrameKind::kPlanar, proto::FrameKind::kGeographic}) {
    build(kind);
    const auto plain = open(PageCoding::kPlain), coded = open(PageCoding::kCoded);
    EXPECT_EQ(plain->coded(), nullptr);
    ASSERT_NE(coded->coded(), nullptr);
    EXPECT_TRUE(areEqual(plain->records(), coded->records()));
    EXPECT_EQ(coded->coded()->damagedGroups(), 0u);
    EXPECT_TRUE(std::ranges::equal(plain->cornerHeights(), coded->cornerHeights()));
    EXPECT_LT(8 * coded->coded()->codedBytes(), 12 * plain->records().size());
    const auto report = verifyScene(path(PageCoding::kCoded), 2);
    ASSERT_TRUE(report.ok());
    EXPECT_TRUE(report->sound()) << report->first_faults.front();
    EXPECT_EQ(report->nodes, verifyScene(path(PageCoding::kPlain), 2)->nodes);
  }
}

TEST_F(CodedScene, MayBeFineInPlacesOnly) {
  for (const auto kind : {proto::FrameKind::kPlanar, proto::FrameKind::kGeographic}) {
    const auto make = [&](PageCoding coding) {
      return test::makeSparseScene(700, 400, test::hills(3), kind, 4, {{200, 210, 60}, {620, 90, 25}}, coding);
    };
    const auto plain = make(PageCoding::kPlain), coded = make(PageCoding::kCoded);
    ASSERT_TRUE(coded->isSparse() && coded->coded());
    EXPECT_TRUE(areEqual(plain->records(), coded->records()));
    EXPECT_EQ(coded->coded()->damagedGroups(), 0u);
    Rng rng(29);
    for (int i = 0; i < 500; ++i) {
      const auto v = proto::NodeId::at(static_cast<uint32_t>(rng.below(700)), static_cast<uint32_t>(rng.below(400)));
      EXPECT_EQ(plain->height(v), coded->height(v));
    }
  }
}

TEST_F(CodedScene, HasTheSameBytesForAnyNumberOfThreads) {
  std::vector<std::vector<char>> files;
  for (unsigned threads : {1u, 2u, 7u}) {
    test::FormulaSource source(150, 131, test::hills(9), proto::FrameKind::kPlanar);
    const auto file = folder / std::to_string(threads);
    ASSERT_TRUE(
        buildScene(source, {.output = file, .threads = threads, .additions = {.page_coding = PageCoding::kCoded}})
            .ok());
    files.push_back(test::slurp(file));
  }
  EXPECT_EQ(files[0], files[1]);
  EXPECT_EQ(files[0], files[2]);
}

TEST_F(CodedScene, DamagedAnywhereIsFoundAndNeverHarms) {
  build(proto::FrameKind::kPlanar, 60, 40);
  const auto bytes = test::slurp(path(PageCoding::kCoded));
  Rng rng(17);
  for (int i = 0; i < 300; ++i) {
    auto damaged = bytes;
    const size_t at = rng.below(bytes.size());
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << rng.below(8)));
    test::spit(folder / "flip.fls", damaged);
    if (const auto scene = MappedScene::open(folder / "flip.fls"); scene.ok()) {
      uint64_t sum = 0;
      for (const NodeRecord& record : (*scene)->records()) sum += record.bits;
      volatile uint64_t kept = sum;
      (void)kept;
    }
    EXPECT_FALSE(openVerified(folder / "flip.fls", 1).ok()) << "byte " << at;
  }
}

// Damage that no checksum sees: the file was written so.
TEST_F(CodedScene, ThatWasWrittenDamagedIsUnsoundAndItsGroupsAreZeros) {
  build();
  const auto sound = test::slurp(path(PageCoding::kCoded));
  FileHeader header;
  std::memcpy(&header, sound.data(), sizeof(header));
  const auto expectDamaged = [&](uint64_t group, const auto& changeEnd) {
    auto bytes = sound;
    char* at = bytes.data() + header.sections[kNodes].offset + (1 + group) * sizeof(uint64_t);
    uint64_t end = 0;
    std::memcpy(&end, at, sizeof(end));
    end = changeEnd(end);
    std::memcpy(at, &end, sizeof(end));
    test::spit(folder / "bad.fls", bytes);
    const auto bad = MappedScene::open(folder / "bad.fls");
    ASSERT_TRUE(bad.ok());
    for (uint64_t i = 0; i < kGroupRecords; ++i)
      ASSERT_EQ((*bad)->records()[group * kGroupRecords + i].bits, 0u) << "record " << i << " of group " << group;
    EXPECT_GT((*bad)->coded()->damagedGroups(), 0u);
    const auto report = verifyScene(folder / "bad.fls", 1);
    ASSERT_TRUE(report.ok());
    EXPECT_FALSE(report->sound());
  };
  expectDamaged(1, [](uint64_t) { return ~uint64_t{0}; });
  expectDamaged(2, [](uint64_t) { return uint64_t{1} << 40; });
  expectDamaged(2, [](uint64_t end) { return end - 40; });
  expectDamaged(3, [](uint64_t) { return uint64_t{0}; });
}

// Any records at all come back, whatever they are.
class GroupCodec : public testing::Test {
 protected:
  proto::GridTopology grid = *proto::GridTopology::create(proto::GridTopology::shapeFor(130, 97));
  proto::PageDirectory directory{grid};
  proto::Frame frame = test::makeFrame(proto::FrameKind::kPlanar, 130, 97);
  std::vector<int32_t> corners = std::vector<int32_t>((grid.shape().roots_x + 1) * (grid.shape().roots_y + 1), 5),
                       centres = std::vector<int32_t>(grid.shape().roots_x * grid.shape().roots_y, -7);
  std::vector<NodeRecord> records = std::vector<NodeRecord>(grid.slotCount());

  CodedTerrain terrain() const { return {grid, directory, records, {corners, centres}, frame}; }
  GroupReader reader() const {
    return {records.size(), [this](uint64_t first, std::span<NodeRecord> out) {
              std::copy_n(records.begin() + static_cast<ptrdiff_t>(first), out.size(), out.begin());
              return Status();
            }};
  }
  void expectRoundTrip(const ModelStart& start) const {
    GroupReader read = reader();
    for (uint64_t group = 0; group < groupCount(directory.pageCount()); ++group) {
      Bytes bytes;
      PageModel model;
      start.apply(model);
      encodeGroup(terrain(), read, group, model, bytes);
      std::vector<NodeRecord> back(terrain().countOf(group), NodeRecord{~uint64_t{0}});
      start.apply(model);
      ASSERT_TRUE(decodeGroup(terrain(), group, bytes, model, back)) << group;
      ASSERT_TRUE(areEqual(back, std::span<const NodeRecord>(records).subspan(terrain().firstOf(group), back.size())));
    }
  }
};

TEST_F(GroupCodec, GivesBackAnyRecords) {
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    // Pages as builders make them, up to the largest heights, among pages of noise and zeros.
    for (proto::Slot slot = 0; slot < records.size(); ++slot) {
      const proto::NodeId n = grid.node(slot);
      const uint64_t kind = (slot / proto::kPageSlots * 7 + seed) % 4;
      if (kind == 0) {
        records[slot] = {rng.next()};
      } else if (kind == 1 || n == proto::NodeId{}) {
        records[slot] = {};
      } else {
        const auto heightOf = [&](proto::NodeId v) {
          return grid.isBase(v) ? proto::BaseHeights{corners, centres}.at(grid, v) : records[grid.slot(v)].height();
        };
        const auto ends = grid.endpoints(n);
        const auto height = static_cast<int32_t>(rng.below(2 * proto::kMaxHeight)) - proto::kMaxHeight;
        records[slot] = NodeRecord::of(height, height - proto::middleOf(heightOf(ends[0]), heightOf(ends[1])),
                                       {static_cast<uint8_t>(rng.below(256))}, {static_cast<uint8_t>(kind)});
      }
    }
    expectRoundTrip(ModelStart());
    ModelTrainer trainer;
    GroupReader read = reader();
    trainer.add(terrain(), read, 0);
    const ModelStart start = trainer.start();
    ModelStart again;
    ASSERT_TRUE(again.decode(start.encode()));
    EXPECT_EQ(again, start);
    expectRoundTrip(start);
  }
}

// Whatever is asked for, it gives the records that are there, the last that were asked for stay where they are, and it
// reads again only what it could not keep.
TEST(GroupReader, GivesWhatIsThereAndKeepsTheLast) {
  constexpr uint64_t kGroups = 3 * GroupReader::kHeld, kPlaces = kGroups * kGroupRecords - 100;
  uint64_t reads = 0;
  GroupReader reader(kPlaces, [&](uint64_t first, std::span<NodeRecord> out) {
    ++reads;
    for (size_t i = 0; i < out.size(); ++i) out[i] = {first + i};
    return first / kGroupRecords == 7 ? Status(Error{ErrorCode::kIo, "seven"}) : Status();
  });
  EXPECT_EQ(reader.group(kGroups - 1).size(), kGroupRecords - 100);
  Rng rng(test::randomSeed());
  std::vector<const NodeRecord*> last;
  for (int i = 0; i < 5000; ++i) {
    const uint64_t place = 8 * kGroupRecords + rng.below(kPlaces - 8 * kGroupRecords);
    last.push_back(&reader.at(place));
    ASSERT_EQ(last.back()->bits, place);
    if (last.size() > GroupReader::kHeld) {
      const uint64_t before = last[last.size() - GroupReader::kHeld]->bits, seen = reads;
      ASSERT_EQ(reader.at(before).bits, before);
      ASSERT_EQ(reads, seen);
      last.push_back(&reader.at(before));
    }
  }
  EXPECT_TRUE(reader.status().ok());
  EXPECT_EQ(reader.at(7 * kGroupRecords + 5).bits, 0u);
  EXPECT_EQ(reader.status().error().message, "seven");
}

TEST_F(GroupCodec, TakesAnyBytes) {
  Rng rng(23);
  int taken = 0;
  for (int i = 0; i < 400; ++i) {
    Bytes bytes(rng.below(i % 2 ? 40 : 20000));
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(i % 3 ? rng.next() : 0xff * (rng.next() & 1));
    PageModel model;
    ModelStart start;
    if (const ByteSpan random(bytes); !start.decode(random)) start = {};
    start.apply(model);
    const uint64_t group = rng.below(groupCount(directory.pageCount()));
    std::vector<NodeRecord> out(terrain().countOf(group));
    taken += decodeGroup(terrain(), group, bytes, model, out) ? 1 : 0;
  }
  EXPECT_LT(taken, 40);
}

// Groups of numbers that follow from theirs and from the first number of the group before.
class PageCacheTest : public testing::Test {
 protected:
  static constexpr uint64_t kGroup = 4096, kGroups = 3000;

  void make(uint64_t cache_bytes) {
    auto made = PageCache::create({.bytes = kGroups * kGroup - 100, .group_bytes = kGroup, .cache_bytes = cache_bytes},
                                  [&](uint64_t group, std::span<uint8_t> out) {
                                    ++inflations;
                                    const uint8_t before = group % 16 == 0 ? 0 : cache->bytes()[(group - 1) * kGroup];
                                    for (size_t i = 0; i < out.size(); ++i) out[i] = valueAt(before, i);
                                  });
    ASSERT_TRUE(made.ok()) << made.error().message;
    cache = std::move(*made);
  }
  static uint8_t valueAt(uint8_t before, size_t i) { return static_cast<uint8_t>(before + 3 + i * 7); }
  static uint8_t expected(uint64_t at) { return valueAt(static_cast<uint8_t>(3 * (at / kGroup % 16)), at % kGroup); }

  std::atomic<uint64_t> inflations{0};
  std::unique_ptr<PageCache> cache;
};

TEST_F(PageCacheTest, ReadsAsIfAllWereThereAndHoldsNoMoreThanItsFrames) {
  make(0);
  const auto frames = cache->counts().frames;
  ASSERT_LT(frames, kGroups / 4) << "too many processors for this test; enlarge it";
  Rng rng(5);
  for (int i = 0; i < 4000; ++i) {
    const uint64_t at = rng.below(cache->bytes().size());
    ASSERT_EQ(cache->bytes()[at], expected(at)) << at;
    ASSERT_LE(cache->counts().held, frames);
  }
  const auto counts = cache->counts();
  EXPECT_GT(counts.evicted, 0u);
  EXPECT_GT(counts.woken, 0u);
  EXPECT_EQ(counts.inflated, counts.evicted + counts.held);
  EXPECT_EQ(cache->bytes().back(), expected(cache->bytes().size() - 1));
}

TEST_F(PageCacheTest, InflatesNothingTwiceThatFits) {
  make(kGroups * kGroup);
  for (int round = 0; round < 3; ++round)
    for (uint64_t at = 0; at < cache->bytes().size(); at += 1000) ASSERT_EQ(cache->bytes()[at], expected(at));
  EXPECT_EQ(inflations, kGroups);
  EXPECT_EQ(cache->counts().evicted, 0u);
}

// What is read again and again stays, however much is read once.
TEST_F(PageCacheTest, KeepsWhatIsUsed) {
  make(0);
  const auto frames = cache->counts().frames;
  for (uint64_t group = 0; group < kGroups; ++group) {
    ASSERT_EQ(cache->bytes()[group * kGroup], expected(group * kGroup));
    for (uint64_t used = 0; used < 16; ++used) ASSERT_EQ(cache->bytes()[used * kGroup], expected(used * kGroup));
  }
  EXPECT_GT(kGroups, 4 * frames);
  EXPECT_LT(inflations, kGroups + 16 * 4);
}

TEST_F(PageCacheTest, ReadsTheSameOnAllThreadsAtOnce) {
  make(0);
  std::vector<std::jthread> threads;
  std::atomic<int> wrong{0};
  for (uint64_t t = 0; t < 6; ++t)
    threads.emplace_back([&, t] {
      Rng rng(100 + t);
      for (int i = 0; i < 1500; ++i) {
        const uint64_t at = rng.below(cache->bytes().size());
        if (cache->bytes()[at] != expected(at)) ++wrong;
      }
    });
  threads.clear();
  EXPECT_EQ(wrong, 0);
  EXPECT_LE(cache->counts().held, cache->counts().frames);
}

}  // namespace
}  // namespace foreland::terrain
