// Paged sets of slots against two sets that do the same slowly.
#include "proto/refine/memory/paged_nodes.h"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "base/rng.h"

namespace foreland::proto {
namespace {

struct Page : NodePage {
  uint32_t own = 0;  // stays with the page
};
using Nodes = PagedNodes<Page>;

class PagedNodesAndReference {
 public:
  explicit PagedNodesAndReference(uint64_t seed) : rng_(seed) {}

  void change(bool grows) {
    const Slot slot = static_cast<Slot>(rng_.below(40) << 8 | rng_.below(8) << 5 | 7);
    const uint8_t low = lowOf(slot);
    uint32_t page = nodes_.find(slot);
    const bool is_section = rng_.below(2) == 0;
    std::set<Slot>& set = is_section ? in_section_ : on_frontier_;
    if (grows ? rng_.below(4) > 0 : rng_.below(16) == 0) {
      if (page == Nodes::kNone) nodes_.page(page = nodes_.makePage(slot)).own = slot / kPageSlots;
      is_section ? nodes_.addToSection(page, low) : nodes_.addToFrontier(page, low);
      set.insert(slot);
    } else if (page != Nodes::kNone) {
      is_section ? nodes_.removeFromSection(page, low) : nodes_.removeFromFrontier(page, low);
      set.erase(slot);
    }
  }
  void endStep() {
    nodes_.orderPages();
    const size_t before = nodes_.size();
    nodes_.dropEmpty();
    dropped_ += before - nodes_.size();
    if (rng_.below(3) == 0) nodes_.compact();
  }
  void compare() {
    nodes_.validate();
    std::vector<Slot> in_section, on_frontier;
    nodes_.forEachInSection([&](Slot slot) { in_section.push_back(slot); });
    nodes_.forEachOnFrontier([&](Slot slot) { on_frontier.push_back(slot); });
    ASSERT_EQ(in_section, std::vector<Slot>(in_section_.begin(), in_section_.end()));
    ASSERT_EQ(on_frontier, std::vector<Slot>(on_frontier_.begin(), on_frontier_.end()));
    for (const Nodes::PageName& name : nodes_.pages()) ASSERT_EQ(nodes_.page(name.number).own, name.key);
    const auto every = static_cast<uint32_t>(1 + rng_.below(20));
    std::vector<Slot> sampled, some;
    nodes_.sampleSection(every, [&](Slot slot) { sampled.push_back(slot); });
    for (size_t i = every / 2; i < in_section.size(); i += every) some.push_back(in_section[i]);
    ASSERT_EQ(sampled, some) << "one in " << every;
    for (int i = 0; i < 200; ++i) {
      const Slot slot = static_cast<Slot>(rng_.below(45 << 8)), first = slot - slot % 64;
      ASSERT_EQ(nodes_.isInSection(slot), in_section_.contains(slot));
      ASSERT_EQ(nodes_.isOnFrontier(slot), on_frontier_.contains(slot));
      ASSERT_EQ(nodes_.hasAnyOf64(first), hasAny(in_section_, first, 64) || hasAny(on_frontier_, first, 64));
    }
    std::vector<uint32_t> keys, expected;
    for (const Nodes::PageName& name : nodes_.pagesOf(5 * kPageSlots, 20 * kPageSlots)) keys.push_back(name.key);
    for (Slot key = 5; key < 20; ++key)
      if (hasAny(in_section_, key * kPageSlots, kPageSlots) || hasAny(on_frontier_, key * kPageSlots, kPageSlots))
        expected.push_back(key);
    ASSERT_EQ(keys, expected);
  }

  size_t dropped() const { return dropped_; }

 private:
  static bool hasAny(const std::set<Slot>& slots, Slot first, Slot count) {
    const auto it = slots.lower_bound(first);
    return it != slots.end() && *it < first + count;
  }

  Rng rng_;
  Nodes nodes_;
  std::set<Slot> in_section_, on_frontier_;
  size_t dropped_ = 0;
};

TEST(PagedNodes, AreTwoSetsOfSlots) {
  const auto seed = static_cast<uint64_t>(testing::UnitTest::GetInstance()->random_seed());
  SCOPED_TRACE("seed " + std::to_string(seed));
  PagedNodesAndReference pair(seed);
  for (int step = 0; step < 400; ++step) {
    // Up to most slots and down to few, so that pages are made and dropped.
    for (int i = 0; i < 100; ++i) pair.change(step / 50 % 2 == 0);
    pair.endStep();
    pair.compare();
    if (testing::Test::HasFatalFailure()) return;
  }
  EXPECT_GT(pair.dropped(), 100u);
}

}  // namespace
}  // namespace foreland::proto
