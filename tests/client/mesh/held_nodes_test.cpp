// The nodes of two sections equal two sets of slots, through any steps.
#include "client/mesh/terrain/held_nodes.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "base/rng.h"

namespace foreland::client {
namespace {

using proto::NodeRecord;
using proto::Slot;

class HeldNodesTest : public testing::Test {
 protected:
  // Adds up to `most` nodes that are not in `to_`, and removes an eighth of those that are.
  proto::CutDelta drawDelta(uint64_t most) {
    const uint64_t reach = uint64_t{1} << (4 + rng_.below(26));
    std::set<Slot> added, removed;
    for (uint64_t i = rng_.below(most); i > 0; --i)
      if (const Slot slot = static_cast<Slot>(rng_.below(reach)); !to_.count(slot)) added.insert(slot);
    for (Slot slot : to_)
      if (rng_.below(8) == 0) removed.insert(slot);
    return {{added.begin(), added.end()}, {removed.begin(), removed.end()}};
  }

  void step() {
    const proto::CutDelta delta = drawDelta(300);
    for (Slot slot : delta.added) {
      heights_[slot] = static_cast<int32_t>(rng_.below(20000)) - 10000;
      held_.records().make(slot) = NodeRecord::of(heights_[slot], 0, {}, {});
    }
    for (uint64_t i = rng_.below(200); i > 0; --i) {  // known, but in no section
      const Slot slot = static_cast<Slot>(rng_.below(1u << 30));
      if (!to_.count(slot) && !heights_.count(slot)) held_.records().make(slot) = NodeRecord::of(7, 0, {}, {});
    }
    held_.step(delta);
    from_ = to_;
    to_.insert(delta.added.begin(), delta.added.end());
    for (Slot slot : delta.removed) to_.erase(slot);
  }

  void expectSame() const {
    EXPECT_EQ(held_.newest().slots, std::vector<Slot>(to_.begin(), to_.end()));
    std::set<Slot> both = from_;
    both.insert(to_.begin(), to_.end());
    const HeldNodes::Index index(held_);
    ASSERT_EQ(index.size(), both.size());
    EXPECT_EQ(index.fromCount(), from_.size());
    EXPECT_EQ(index.toCount(), to_.size());
    uint32_t position = 0;
    for (Slot slot : both) {
      const HeldNodes::Index::Found found = index.find(slot);
      ASSERT_EQ(found.position, position++);
      ASSERT_EQ(index.height(found), heights_.at(slot));
      ASSERT_EQ(found.in, (from_.count(slot) ? kInFrom : 0) | (to_.count(slot) ? kInTo : 0));
      ASSERT_EQ(held_.in(slot), found.in);
    }
    for (const auto& [slot, height] : heights_) {
      if (both.count(slot)) continue;
      ASSERT_EQ(index.find(slot).position, HeldNodes::Index::kAbsent);
      ASSERT_EQ(held_.in(slot), 0);
    }
  }

  const uint64_t seed_ = testing::UnitTest::GetInstance()->random_seed();
  Rng rng_{seed_};
  const proto::GridTopology grid_ = proto::GridTopology::create({2, 2, 6, 129, 129}).value();
  const std::vector<int32_t> corners_ = std::vector<int32_t>(9), centres_ = std::vector<int32_t>(4);
  HeldNodes held_{grid_, {corners_, centres_}};
  std::set<Slot> from_, to_;
  std::map<Slot, int32_t> heights_;  // of all nodes that were ever in a section
};

TEST_F(HeldNodesTest, FollowTheSections) {
  SCOPED_TRACE("seed " + std::to_string(seed_));
  for (int i = 0; i < 60; ++i) {
    step();
    ASSERT_NO_FATAL_FAILURE(expectSame());
  }
}

TEST_F(HeldNodesTest, ForgetOnlyWhatIsNotKnown) {
  SCOPED_TRACE("seed " + std::to_string(seed_));
  constexpr Slot kBlock = proto::SparseNodes::kBlockSlots;
  const auto isKnown = [](Slot first) { return first / kBlock % 5 == 0; };
  bool has_forgotten = false;
  for (int i = 0; i < 100; ++i) {
    step();
    const uint32_t before = held_.records().blockCount();
    std::set<Slot> known;
    for (uint32_t block = 1; block < before; ++block)
      if (const Slot first = held_.records().first(block); isKnown(first)) known.insert(first);
    held_.forget(isKnown);
    has_forgotten = has_forgotten || held_.records().blockCount() < before;
    for (Slot first : known) ASSERT_NE(held_.records().block(first), proto::SparseNodes::kNone);
    ASSERT_NO_FATAL_FAILURE(expectSame());
  }
  EXPECT_TRUE(has_forgotten);
}

}  // namespace
}  // namespace foreland::client
