// The memory of pages is a list of them, the one used last first, cut off where the budget ends.
#include "proto/refine/memory/node_memory.h"

#include <gtest/gtest.h>

#include <list>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::proto {
namespace {

// From no known node to all of them.
PageKnowledge randomKnowledge(Rng& rng) {
  PageKnowledge knowledge;
  const uint64_t known_of_8 = rng.below(9), settled_of_8 = rng.below(9);
  for (uint32_t low = 0; low < kPageSlots; ++low) {
    const bool is_known = rng.below(8) < known_of_8;
    knowledge.known.add(static_cast<uint8_t>(low), is_known);
    knowledge.settled.add(static_cast<uint8_t>(low), is_known && rng.below(8) < settled_of_8);
  }
  knowledge.radius = {static_cast<uint8_t>(rng.below(128))};
  knowledge.finest = {static_cast<uint8_t>(rng.below(256))};
  return knowledge;
}

size_t costOf(const PageKnowledge& knowledge) {
  size_t blocks = 0;
  for (int block = 0; block < 4; ++block) {
    bool any = false;
    for (int low = 64 * block; low < 64 * block + 64; ++low)
      any = any || knowledge.known.has(static_cast<uint8_t>(low));
    blocks += any ? 1 : 0;
  }
  return 128 + 512 * blocks;
}

class ListOfPages {
 public:
  explicit ListOfPages(size_t budget) : budget_(budget) {}
  void keep(const KnownPage& page) {
    pages_.push_front(page);
    while (cost() > budget_) pages_.pop_back();
  }
  void setBudget(size_t budget) {
    budget_ = budget;
    while (cost() > budget_) pages_.pop_back();
  }
  bool take(Slot first, PageKnowledge& out) {
    for (auto it = pages_.begin(); it != pages_.end(); ++it)
      if (it->first == first) {
        out = it->knowledge;
        pages_.erase(it);
        return true;
      }
    return false;
  }
  size_t cost() const {
    size_t sum = 0;
    for (const KnownPage& page : pages_) sum += costOf(page.knowledge);
    return sum;
  }
  const std::list<KnownPage>& pages() const { return pages_; }

 private:
  size_t budget_;
  std::list<KnownPage> pages_;
};

// Keys that take three bytes and keys that take more.
Slot firstOfPage(uint64_t n) { return (n % 2 == 0 ? n : n << 42) * kPageSlots; }

TEST(NodeMemory, IsAListOfPagesCutOffWhereTheBudgetEnds) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  size_t taken = 0;
  for (size_t budget : {size_t{0}, size_t{700}, size_t{20'000}, size_t{1} << 20}) {
    NodeMemory memory;
    memory.setBudget(budget);
    ListOfPages list(budget);
    size_t most = 0;
    for (int i = 0; i < 3000; ++i) {
      const Slot first = firstOfPage(rng.below(60)), slot = first | rng.below(256);
      PageKnowledge expected;
      const bool is_there = list.take(first, expected);
      const auto found = memory.find(slot);
      ASSERT_EQ(memory.knowsAnyOf64(slot & ~Slot{63}), is_there && expected.knowsAnyOf64(slot))
          << "seed " << seed << ", step " << i;
      ASSERT_EQ(memory.radius(slot), is_there ? std::optional(expected.radius) : std::nullopt);
      ASSERT_EQ(found.has_value(), is_there) << "seed " << seed << ", step " << i;
      const auto got = memory.take(slot);
      ASSERT_EQ(got.has_value(), is_there);
      if (is_there) {
        ASSERT_EQ(*got, expected);
        ASSERT_EQ(*found, expected);
      }
      taken += is_there ? 1 : 0;
      if (rng.below(3) > 0) {
        const KnownPage page{first, randomKnowledge(rng)};
        memory.keep(page.first, page.knowledge);
        list.keep(page);
      }
      if (rng.below(500) == 0) {
        budget = rng.below(2 * budget + 1);
        memory.setBudget(budget);
        list.setBudget(budget);
      }
      const std::vector<KnownPage> all = memory.pages();
      size_t known = 0;
      for (const KnownPage& page : all) known += page.knowledge.known.count();
      ASSERT_TRUE(std::equal(all.begin(), all.end(), list.pages().begin(), list.pages().end()))
          << "seed " << seed << ", step " << i;
      ASSERT_EQ(memory.clientBytes(), list.cost());
      ASSERT_EQ(memory.pageCount(), all.size());
      ASSERT_EQ(memory.knownCount(), known);
      most = std::max(most, all.size());
    }
    EXPECT_LT(memory.bytes(), 90 * (most + 40)) << "of any bits, which do not get shorter";
  }
  EXPECT_GT(taken, 10u);
}

}  // namespace
}  // namespace foreland::proto
