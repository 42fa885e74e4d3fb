// What a client presents to resume: its sections, and what else it knows of the terrain.
#include "proto/codec/section_codec.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::proto {
namespace {

// All levels are whole, or some are sparse.
class SectionCodec : public testing::TestWithParam<GridShape> {
 protected:
  static GridTopology grid() { return std::move(GridTopology::create(GetParam())).value(); }
};
INSTANTIATE_TEST_SUITE_P(Sparse, SectionCodec,
                         testing::Values(GridShape{2, 1, 5, 65, 33}, GridShape{2, 1, 5, 65, 33, 5},
                                         GridShape{2, 1, 5, 65, 33, 8}, GridTopology::cubeShape(4),
                                         GridTopology::cubeShape(5, 6)));

bool hasParents(const GridTopology& topology, const std::set<Slot>& slots, NodeId n) {
  const auto parents = topology.parents(n);
  return std::all_of(parents.begin(), parents.end(), [&](NodeId p) { return slots.contains(topology.slot(p)); });
}

// A random closed set; `share` of what could be added is.
std::set<Slot> closedSet(const GridTopology& topology, double share, Rng& rng) {
  std::set<Slot> slots;
  for (Slot slot = 0; slot < topology.slotCount(); ++slot) {
    const NodeId n = topology.node(slot);
    if (!topology.isBase(n) && hasParents(topology, slots, n) && rng.uniform(0, 1) < share) slots.insert(slot);
  }
  return slots;
}

std::vector<KnownPage> pagesOf(const std::set<Slot>& known, Rng& rng) {
  std::vector<KnownPage> pages;
  for (Slot slot : known) {
    if (pages.empty() || pages.back().first != slot / kPageSlots * kPageSlots) {
      pages.push_back({slot / kPageSlots * kPageSlots, {}});
      pages.back().knowledge.finest = {static_cast<uint8_t>(rng.below(256))};
    }
    pages.back().knowledge.known.set(static_cast<uint8_t>(slot));
  }
  return pages;
}

TEST_P(SectionCodec, PresentsWhatIsKnownAsFarAsItsParentsAre) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  const GridTopology topology = grid();
  size_t dropped = 0, presented = 0;
  for (int round = 0; round < 60; ++round) {
    const std::set<Slot> section = closedSet(topology, rng.uniform(0.3, 0.9), rng);
    // Known are the section, a closed set, and some that stand alone.
    std::set<Slot> closed = closedSet(topology, rng.uniform(0, 1), rng), known = section;
    known.insert(closed.begin(), closed.end());
    for (int i = 0; i < 20; ++i) {
      const Slot slot = static_cast<Slot>(rng.below(topology.slotCount()));
      if (!topology.isBase(topology.node(slot))) known.insert(slot);
    }
    HeldSections held{{{section.begin(), section.end()}}, {}, pagesOf(known, rng)};
    Bytes bytes;
    const std::vector<KnownPage> said = encodeSections(topology, {}, held, bytes);
    const auto heard = decodeSections(topology, {}, bytes, topology.slotCount());
    ASSERT_TRUE(heard.ok()) << "seed " << seed;
    EXPECT_EQ(heard->terrain, held.terrain);
    EXPECT_EQ(heard->known, said) << "seed " << seed;
    // By the simplest rule: what is known with all ancestors known.
    std::set<Slot> expected;
    for (Slot slot : known)
      if (hasParents(topology, expected, topology.node(slot))) expected.insert(slot);
    std::set<Slot> got;
    for (const KnownPage& page : said) {
      page.knowledge.known.forEach([&](uint8_t low) { got.insert(page.first | low); });
      const auto given = std::find_if(held.known.begin(), held.known.end(),
                                      [&](const KnownPage& other) { return other.first == page.first; });
      EXPECT_EQ(page.knowledge.finest, given->knowledge.finest);
      EXPECT_FALSE(page.knowledge.settled.any());
    }
    EXPECT_EQ(got, expected) << "seed " << seed;
    dropped += known.size() - got.size();
    presented += got.size() - section.size();
    // As many nodes beside the section are taken as of the section.
    const size_t most = std::max(section.size(), got.size() - section.size());
    EXPECT_TRUE(decodeSections(topology, {}, bytes, most).ok());
    if (most > 0) { EXPECT_FALSE(decodeSections(topology, {}, bytes, most - 1).ok()); }
  }
  EXPECT_GT(dropped, 0u);
  EXPECT_GT(presented, 0u);
}

TEST_P(SectionCodec, WithoutPagesTheSectionIsKnownAndNothingElse) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  const GridTopology topology = grid();
  const std::set<Slot> section = closedSet(topology, 0.8, rng);
  Bytes bytes;
  const auto said = encodeSections(topology, {}, {{{section.begin(), section.end()}}, {}, {}}, bytes);
  std::set<Slot> known;
  for (const KnownPage& page : said) {
    page.knowledge.known.forEach([&](uint8_t low) { known.insert(page.first | low); });
    EXPECT_EQ(page.knowledge.finest, QuantisedError{}) << "nothing is known of errors";
  }
  EXPECT_EQ(known, section) << "seed " << seed;
}

TEST_P(SectionCodec, AnyBytesEndInClosedSetsOrAnError) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  const GridTopology topology = grid();
  size_t taken = 0;
  for (int round = 0; round < 500; ++round) {
    Bytes bytes(rng.below(40));
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(rng.below(256));
    const auto heard = decodeSections(topology, {}, bytes, 1000);
    if (!heard.ok()) continue;
    ++taken;
    std::set<Slot> known;
    for (const KnownPage& page : heard->known)
      page.knowledge.known.forEach([&](uint8_t low) { known.insert(page.first | low); });
    for (Slot slot : heard->terrain.slots) EXPECT_TRUE(known.contains(slot));
    for (Slot slot : known) EXPECT_TRUE(hasParents(topology, known, topology.node(slot))) << "seed " << seed;
    EXPECT_LE(known.size(), 2000u);
  }
  EXPECT_GT(taken, 0u) << "seed " << seed;
}

}  // namespace
}  // namespace foreland::proto
