// A frontier's entries against a map that does the same slowly.
#include "proto/refine/frontier.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/rng.h"

namespace foreland::proto {
namespace {

struct Expected {
  QuantisedError bound;
  float slack;
  MotionConstraint constraint;
};

// A frontier and what it should be. Slacks and motions are small whole numbers, so the sums are exact.
class Pair {
 public:
  explicit Pair(uint64_t seed) : rng_(seed) {}

  // Grows and shrinks in turns, so that blocks change their sizes and memory is given back.
  void step(bool grows) {
    consume();
    for (int i = 0; i < 400; ++i) {
      const Slot slot = static_cast<Slot>(rng_.below(40)) << 8 | static_cast<Slot>(rng_.next() & 0xff);
      if (i % 20 == 0) grows ? addSome(slot) : removeSome(slot);
      if (grows ? rng_.below(4) > 0 : rng_.below(4) == 0)
        add(slot);
      else
        remove(slot);
    }
    frontier_.orderPages();
    std::vector<Slot> dropped;
    frontier_.endStep([&](const FrontierPage& page) { dropped.push_back(page.first()); });
    ASSERT_TRUE(std::is_sorted(dropped.begin(), dropped.end()));
    for (Slot first : dropped) ASSERT_TRUE(pages_.erase(first));
    compare();
  }
  size_t size() const { return entries_.size(); }

 private:
  void add(Slot slot) {
    uint32_t page = frontier_.nodes().find(slot);
    if (page == kNone) {
      page = frontier_.makePage(slot, {.known = {}, .settled = {}, .radius = radiusOf(slot)});
      pages_.insert(slot & ~Slot{0xff});
    }
    const uint8_t low = static_cast<uint8_t>(slot);
    if (rng_.below(2)) {
      frontier_.addToSection(page, low);
      nodes_in_section_.insert(slot);
    }
    const float max_distance = static_cast<float>(uint64_t{1} << rng_.below(20));
    const Expected e{{static_cast<uint8_t>(rng_.next())},
                     static_cast<float>(rng_.below(2000)),
                     MotionConstraint::of(static_cast<uint32_t>(rng_.below(4)), max_distance)};
    frontier_.put(page, FrontierEntry::of(low, e.bound, e.constraint, e.slack));
    entries_.insert_or_assign(slot, e);
  }
  void remove(Slot slot) {
    const uint32_t page = frontier_.nodes().find(slot);
    if (page == kNone) return;
    if (nodes_in_section_.erase(slot)) frontier_.removeFromSection(page, lowOf(slot));
    if (entries_.erase(slot)) frontier_.leave(page, SlotBits::of(lowOf(slot)));
  }
  // Several nodes of the slot's page at once, none or all of which are on the frontier: what they leave in one by one.
  void addSome(Slot near) {
    const uint32_t page = frontier_.nodes().find(near);
    if (page == kNone) return;
    const SlotBits some = someBits() - frontier_.page(page).on_frontier;
    const QuantisedError bound{static_cast<uint8_t>(rng_.next())};
    frontier_.enter(page, some, FrontierEntry::of(7, bound, {}, 0));
    some.forEach([&](uint8_t low) { entries_[frontier_.page(page).first() | low] = {bound, 0, {}}; });
  }
  void removeSome(Slot near) {
    const uint32_t page = frontier_.nodes().find(near);
    const SlotBits some = someBits() & frontier_.page(page).on_frontier;
    if (page == kNone || !some.any()) return;
    frontier_.leave(page, some);
    some.forEach([&](uint8_t low) { entries_.erase(frontier_.page(page).first() | low); });
  }
  SlotBits someBits() {
    SlotBits some;
    for (uint64_t& word : some.words) word = rng_.next() & rng_.next() & rng_.next();
    return some;
  }
  void consume() {
    MotionBound motion;
    for (size_t g = 0; g < MotionBound::kSensitivities; ++g) {
      motion.fixed[g] = static_cast<float>(1 + rng_.below(50));
      motion.per_distance[g] = rng_.below(2) ? 0 : 0x1p-10f;
    }
    std::set<Slot> expected, stale;
    for (auto& [slot, e] : entries_) {
      const FrontierEntry entry = FrontierEntry::of(0, {}, e.constraint, 0);
      e.slack -= motion.fixed[entry.sensitivity()] + motion.per_distance[entry.sensitivity()] * entry.maxDistance();
      if (e.slack < 0) expected.insert(slot);
    }
    const MotionConstraint renewed = MotionConstraint::of(1, 1);
    frontier_.consume(motion, [&](uint32_t number, const SlotBits& ranks) {
      ranks.forEach([&](uint8_t rank) {
        const FrontierEntry entry = frontier_.entryAt(number, rank);
        stale.insert(frontier_.page(number).first() | entry.low());
        frontier_.renew(number, rank, FrontierEntry::of(entry.low(), entry.bound(), renewed, 1000));
      });
    });
    ASSERT_EQ(stale, expected);
    for (Slot slot : stale) entries_[slot].slack = 1000, entries_[slot].constraint = renewed;
  }
  void compare() {
    frontier_.validate();
    std::vector<Slot> in_section, on_frontier, expected;
    frontier_.nodes().forEachInSection([&](Slot slot) { in_section.push_back(slot); });
    frontier_.nodes().forEachOnFrontier([&](Slot slot) { on_frontier.push_back(slot); });
    for (const auto& [slot, e] : entries_) {
      expected.push_back(slot);
      ASSERT_EQ(frontier_.entry(frontier_.nodes().find(slot), lowOf(slot)).bound(), e.bound);
      ASSERT_EQ(frontier_.nodes().pageAt(slot).knowledge.radius, radiusOf(slot));
    }
    ASSERT_EQ(on_frontier, expected);
    ASSERT_EQ(in_section, std::vector<Slot>(nodes_in_section_.begin(), nodes_in_section_.end()));
    ASSERT_EQ(frontier_.entryCount(), entries_.size());
    ASSERT_EQ(frontier_.nodes().size(), pages_.size());
    // Two thirds of the slots of a page may be empty, and twice as much be held.
    ASSERT_LE(frontier_.bytes(), 40 * 400 + 64 * entries_.size() + (size_t{1} << 16));
  }
  static constexpr uint32_t kNone = Frontier::Nodes::kNone;
  static QuantisedRadius radiusOf(Slot slot) { return {static_cast<uint8_t>(slot >> 8)}; }

  Rng rng_;
  Frontier frontier_{EntryKind::kSlack};
  std::set<Slot> nodes_in_section_, pages_;
  std::map<Slot, Expected> entries_;
};

// A distance that is rounded down would let a turn take too little off a slack.
TEST(MotionConstraint, RoundsTheLargestDistanceUpByAtMost2Percent) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  Rng rng(seed);
  for (int i = 0; i < 20000; ++i) {
    const float distance = static_cast<float>(std::exp2(rng.uniform(-4, 28)));
    const uint32_t sensitivity = static_cast<uint32_t>(i) % 4;
    const auto entry = FrontierEntry::of(7, QuantisedError{60}, MotionConstraint::of(sensitivity, distance), 1);
    ASSERT_GE(entry.maxDistance(), distance) << "seed " << seed;
    ASSERT_LE(entry.maxDistance(), 1.02 * distance) << "seed " << seed;
    ASSERT_EQ(entry.sensitivity(), sensitivity) << "seed " << seed;
  }
}

TEST(Frontier, KeepsItsEntriesAndFindsTheStaleOnes) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Pair pair(seed);
  size_t most = 0, least = 1 << 20;
  for (int i = 0; i < 300; ++i) {
    pair.step(i / 50 % 2 == 0);
    if (testing::Test::HasFatalFailure()) return;
    if (i % 50 == 49) most = std::max(most, pair.size()), least = std::min(least, pair.size());
  }
  EXPECT_GT(most, 2 * least);
}

class FrontierMemory : public testing::TestWithParam<EntryKind> {};

TEST_P(FrontierMemory, IsThatOfItsEntriesAndGivenBack) {
  const size_t entry_bytes = GetParam() == EntryKind::kSlack ? 8 : 5;
  Frontier frontier(GetParam());
  for (Slot key = 0; key < 1000; ++key) {
    const uint32_t page = frontier.makePage(key << 8, {});
    for (int low = 0; low < 256; ++low) frontier.put(page, FrontierEntry::newAddable(static_cast<uint8_t>(low)));
  }
  frontier.orderPages();
  frontier.endStep([](const FrontierPage&) {});
  EXPECT_GE(frontier.bytes(), entry_bytes * 256 * 1000);
  EXPECT_LE(frontier.bytes(), (entry_bytes + 2) * 256 * 1000);
  Slot key = 0;
  for (const Slot left : {700, 500, 100}) {
    for (; key < 1000 - left; ++key)
      for (int low = 0; low < 256; ++low)
        frontier.leave(frontier.nodes().find(key << 8), SlotBits::of(static_cast<uint8_t>(low)));
    frontier.endStep([](const FrontierPage&) {});
    frontier.validate();
    EXPECT_EQ(frontier.entryCount(), 256u * left);
    EXPECT_LE(frontier.bytes(), (entry_bytes + 3) * 256 * left);
  }
}

TEST_P(FrontierMemory, IsGivenBackInOneStep) {
  Frontier frontier(GetParam());
  for (Slot key = 0; key < 1000; ++key) {
    const uint32_t page = frontier.makePage(key << 8, {});
    frontier.enter(page, SlotBits::below(256), FrontierEntry::newAddable(0));
    // Blocks stay larger than they need be until they are copied.
    frontier.leave(page, SlotBits::below(key < 400 ? 256 : 100));
  }
  frontier.orderPages();
  frontier.endStep([](const FrontierPage&) {});
  const size_t bytes = frontier.bytes();
  frontier.endStep([](const FrontierPage&) {});
  EXPECT_EQ(frontier.bytes(), bytes);
}

INSTANTIATE_TEST_SUITE_P(OfBothKinds, FrontierMemory, testing::Values(EntryKind::kSlack, EntryKind::kSwept),
                         [](const auto& kind) { return kind.param == EntryKind::kSlack ? "Slack" : "Swept"; });

TEST(FrontierEntry, KeepsHeightsOfScenesInFiveBytes) {
  using Stands = FrontierEntry::Stands;
  const auto kept = [](int32_t height, Stands stands) {
    const FrontierEntry entry = FrontierEntry::swept(200, {77}, stands, height);
    EXPECT_EQ(entry.low(), 200);
    EXPECT_EQ(entry.bound().value, 77);
    EXPECT_EQ((entry.bits >> 16 & 1) != 0, stands == Stands::kInSection);
    EXPECT_LT(entry.rest, 256u);
    return FrontierEntry::heightOf(entry.bits, static_cast<uint8_t>(entry.rest));
  };
  for (const int32_t height : {0, 1, -1, 32767, 32768, -32768, -32769, 4'000'000, kMaxHeight, 1 - kMaxHeight})
    for (const Stands stands : {Stands::kOutside, Stands::kInSection}) EXPECT_EQ(kept(height, stands), height);
  for (const int32_t height : {-kMaxHeight, kMaxHeight + 1, -kMaxHeight - 1, 1 << 30, FrontierEntry::kUnknown})
    EXPECT_EQ(kept(height, Stands::kOutside), FrontierEntry::kUnknown);
  EXPECT_EQ(kept(5, Stands::kHidden), FrontierEntry::kHidden);
}

}  // namespace
}  // namespace foreland::proto
