// The frontier's tables against sets and maps that do the same slowly.
#include "proto/refine/frontier.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "base/rng.h"

namespace foreland::proto {
namespace {

TEST(SlotBits, AreASetOfSlots) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed() + 1;
  Rng rng(seed);
  SlotBits bits, others;
  std::set<int> expected, other;
  for (int i = 0; i < 3000; ++i) {
    const uint8_t low = static_cast<uint8_t>(rng.next()), at = static_cast<uint8_t>(rng.next());
    if (rng.below(2))
      bits.set(low), expected.insert(low);
    else
      bits.clear(low), expected.erase(low);
    others.set(at), other.insert(at);
    ASSERT_EQ(bits.any(), !expected.empty());
    ASSERT_EQ(bits.count(), expected.size());
    ASSERT_EQ(bits.has(at), expected.contains(at)) << "seed " << seed;
    ASSERT_EQ(bits.countBefore(at), std::distance(expected.begin(), expected.lower_bound(at))) << "seed " << seed;
    std::vector<int> seen;
    bits.forEach([&](uint8_t slot) { seen.push_back(slot); });
    ASSERT_EQ(seen, std::vector<int>(expected.begin(), expected.end()));
    const SlotBits both = bits & others, rest = bits - others;
    ASSERT_EQ(both.has(low), expected.contains(low) && other.contains(low));
    ASSERT_EQ(rest.has(low), expected.contains(low) && !other.contains(low));
    if (i % 300 == 0) others = {}, other.clear();
  }
}

struct Expected {
  QuantisedError bound;
  float slack;
  uint16_t constraint;
};

// A frontier and what it should be. Slacks and motions are small whole numbers, so the sums are exact.
class Pair {
 public:
  explicit Pair(uint64_t seed) : rng_(seed) {}

  // Grows and shrinks in turns, so that rooms change their sizes and memory is given back.
  void step(bool grows) {
    consume();
    for (int i = 0; i < 400; ++i) {
      const Slot slot = static_cast<Slot>(rng_.below(40)) << 8 | static_cast<Slot>(rng_.next() & 0xff);
      if (grows ? rng_.below(4) > 0 : rng_.below(4) == 0)
        add(slot);
      else
        remove(slot);
    }
    frontier_.orderPages();
    frontier_.endStep();
    compare();
  }
  size_t size() const { return listed_.size(); }

 private:
  void add(Slot slot) {
    uint32_t page = frontier_.find(slot);
    if (page == Frontier::kNone) page = frontier_.makePage(slot, radiusOf(slot));
    const uint8_t low = static_cast<uint8_t>(slot);
    if (rng_.below(2)) {
      frontier_.setInSection(page, low, true);
      nodes_in_section_.insert(slot);
    }
    const float max_distance = static_cast<float>(uint64_t{1} << rng_.below(20));
    const Expected e{{static_cast<uint8_t>(rng_.next())},
                     static_cast<float>(rng_.below(2000)),
                     Entry::constraint(max_distance, static_cast<uint32_t>(rng_.below(3)))};
    frontier_.list(page, low, e.bound, e.slack, e.constraint);
    listed_.insert_or_assign(slot, e);
  }
  void remove(Slot slot) {
    const uint32_t page = frontier_.find(slot);
    if (page == Frontier::kNone) return;
    if (nodes_in_section_.erase(slot)) frontier_.setInSection(page, static_cast<uint8_t>(slot), false);
    if (listed_.erase(slot)) frontier_.unlist(page, static_cast<uint8_t>(slot));
  }
  void consume() {
    MotionBound motion;
    for (size_t g = 0; g < 3; ++g) {
      motion.fixed[g] = static_cast<float>(1 + rng_.below(50));
      motion.per_distance[g] = rng_.below(2) ? 0 : 0x1p-10f;
    }
    std::set<Slot> expected, due;
    for (auto& [slot, e] : listed_) {
      const Entry entry = Entry::of(0, {}, e.constraint);
      e.slack -= motion.fixed[entry.sensitivity()] + motion.per_distance[entry.sensitivity()] * entry.max_distance();
      if (e.slack < 0) expected.insert(slot);
    }
    frontier_.consume(motion, [&](uint32_t number, std::span<const uint32_t> places) {
      for (uint32_t place : places) due.insert(frontier_.page(number).first() | frontier_.entryAt(place).low());
      for (uint32_t place : places) frontier_.renew(place, 1000, Entry::constraint(1, 1));
    });
    ASSERT_EQ(due, expected);
    for (Slot slot : due) listed_[slot].slack = 1000, listed_[slot].constraint = Entry::constraint(1, 1);
  }
  void compare() {
    frontier_.validate();
    std::vector<Slot> in_section, on_frontier, expected;
    frontier_.forEachInSection([&](Slot slot) { in_section.push_back(slot); });
    frontier_.forEachOnFrontier([&](Slot slot) { on_frontier.push_back(slot); });
    for (const auto& [slot, e] : listed_) {
      expected.push_back(slot);
      ASSERT_EQ(frontier_.bound(frontier_.page(frontier_.find(slot)), static_cast<uint8_t>(slot)), e.bound);
      ASSERT_EQ(frontier_.radius(slot), radiusOf(slot));
    }
    ASSERT_EQ(on_frontier, expected);
    ASSERT_EQ(in_section, std::vector<Slot>(nodes_in_section_.begin(), nodes_in_section_.end()));
    ASSERT_EQ(frontier_.entryCount(), listed_.size());
    // Two thirds of the slots of a page may be empty, and twice as much be held.
    ASSERT_LE(frontier_.bytes(), 40 * 400 + 64 * listed_.size() + (size_t{1} << 16));
  }
  static QuantisedRadius radiusOf(Slot slot) { return {static_cast<uint8_t>(slot >> 8)}; }

  Rng rng_;
  Frontier frontier_;
  std::set<Slot> nodes_in_section_;
  std::map<Slot, Expected> listed_;
};

TEST(Frontier, KeepsWhatItIsTold) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed() + 1;
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

TEST(Frontier, GivesMemoryBack) {
  Frontier frontier;
  const auto fill = [&](Slot pages, bool comes) {
    for (Slot key = 0; key < pages; ++key) {
      const uint32_t page = comes ? frontier.makePage(key << 8, {}) : frontier.find(key << 8);
      for (int low = 0; low < 256; ++low)
        if (comes)
          frontier.list(page, static_cast<uint8_t>(low), {}, 1, 0);
        else
          frontier.unlist(page, static_cast<uint8_t>(low));
    }
    frontier.orderPages();
    frontier.endStep();
  };
  fill(1000, true);
  EXPECT_GE(frontier.bytes(), size_t{8} * 256 * 1000);
  EXPECT_LE(frontier.bytes(), size_t{10} * 256 * 1000);
  fill(900, false);
  frontier.validate();
  EXPECT_EQ(frontier.entryCount(), 256u * 100);
  EXPECT_LE(frontier.bytes(), size_t{11} * 256 * 100);
}

}  // namespace
}  // namespace foreland::proto
