// A terrain of which deep pages are there or not: adaptation equals refinement from scratch, which equals that of the
// whole terrain whose other nodes have no error; and what is not there costs next to nothing.
#include <gtest/gtest.h>

#include "proto/codec/delta_codec.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"
#include "tests/support/wanderer.h"

namespace foreland::proto {
namespace {

using server::Hierarchy;

constexpr size_t kNoLimit = 1u << 30;

// A scene's nodes, as far as their pages are kept: those of all but the last levels, and those that some nodes need.
class SparseScene {
 public:
  SparseScene(const Hierarchy& whole, uint32_t levels, Rng& rng)
      : domain_(*GridTopology::create(sparse(whole.grid().shape(), levels)), whole.scene().frame()),
        zeroed_(whole.grid().slotCount()),
        base_{whole.scene().cornerHeights(), whole.scene().centreHeights()} {
    std::vector<Slot> kept;
    for (int i = 0; i < 4; ++i) kept.push_back(rng.below(domain_.grid.slotCount()));
    blocks_ = blocksOf(domain_.grid, kept);
    directory_ = std::move(PageDirectory::create(domain_.grid, blocks_)).value();
    records_.resize(directory_.pageCount() * kPageSlots);
    for (Slot slot = 0; slot < zeroed_.size(); ++slot)
      if (directory_.hasPage(slot)) zeroed_[slot] = records_[directory_.placeOf(slot)] = whole.nodes()[slot];
  }
  SparseScene(const SparseScene&) = delete;
  SparseScene& operator=(const SparseScene&) = delete;

  const TerrainDomain& domain() const { return domain_; }
  StoredNodes nodes() const { return {records_, directory_}; }
  DenseNodes table() const { return {domain_.grid, base_, nodes()}; }
  BaseHeights base() const { return base_; }
  // All slots; zeros where no page is.
  std::span<const NodeRecord> zeroed() const { return zeroed_; }

 private:
  static GridShape sparse(GridShape shape, uint32_t levels) {
    shape.sparse_levels = levels;
    return shape;
  }

  TerrainDomain domain_;
  std::vector<NodeRecord> zeroed_, records_;
  std::vector<PageBlock> blocks_;
  PageDirectory directory_{domain_.grid};
  BaseHeights base_;
};

class SparseLevels : public testing::TestWithParam<FrameKind> {};

TEST_P(SparseLevels, AreRefinedAsFarAsPagesAreThere) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  const Hierarchy whole(test::makeScene(190u, 129u, seed, GetParam()));
  size_t held_back = 0;
  for (const uint32_t levels : {2u, 5u, 8u}) {
    const SparseScene scene(whole, levels, rng);
    test::Wanderer wanderer(whole, rng.next());
    TerrainAdapter adapter(scene.domain());
    InMemoryNodes source(scene.nodes());
    AdaptScratch adapt_scratch;
    RefineScratch scratch;
    Section expected, zeroed, all;
    for (int i = 0; i < 200; ++i) {
      const View view = wanderer.next();
      CutDelta delta;
      ASSERT_TRUE(adapter.adapt(view, kNoLimit, source, adapt_scratch, delta));
      adapter.validate();
      ASSERT_TRUE(refine(scene.domain(), scene.nodes(), view, kNoLimit, scratch, expected));
      ASSERT_EQ(adapter.section(), expected) << "seed " << seed << ", step " << i;
      ASSERT_TRUE(validate(scene.domain().grid, expected).ok());
      ASSERT_TRUE(refine(scene.domain(), scene.zeroed(), view, kNoLimit, scratch, zeroed));
      ASSERT_EQ(expected, zeroed) << "seed " << seed << ", step " << i;
      ASSERT_TRUE(refine(whole, view, kNoLimit, scratch, all));
      held_back += all.slots.size() - expected.slots.size();
    }
  }
  EXPECT_GT(held_back, 0u) << "seed " << seed;
}

// Both ends of a stream, over the same flight.
struct Ends {
  explicit Ends(const SparseScene& s)
      : scene(s), server(s.domain()), client(s.domain()), held(s.domain().grid, s.base()) {}

  // The section that both hold then; false if the client refuses.
  bool step(const View& view) {
    Bytes bytes;
    CutDelta sent, got;
    const DenseNodes table = scene.table();
    DeltaEncoder encoder(scene.domain(), table, server_model, bytes);
    CHECK_TRUE(server.adapt(view, kNoLimit, encoder, scratch, sent));
    encoder.finish();
    bits.pages += encoder.bits().pages;
    bits.pages_asked += encoder.bits().pages_asked;
    bits.added += sent.added.size();
    DeltaDecoder decoder(scene.domain(), held, client_model, bytes);
    return client.adapt(view, kNoLimit, decoder, scratch, got) && decoder.finish().ok() && got == sent;
  }

  const SparseScene& scene;
  TerrainAdapter server, client;
  DeltaModel server_model, client_model;
  SparseNodes held;
  AdaptScratch scratch;
  DeltaBits bits;
};

TEST_P(SparseLevels, AreToldToTheClientPageByPage) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  const Hierarchy whole(test::makeScene(257u, 200u, seed, GetParam()));
  const SparseScene scene(whole, 8, rng);
  test::Wanderer wanderer(whole, rng.next());
  Ends ends(scene);
  for (int i = 0; i < 200; ++i) {
    ASSERT_TRUE(ends.step(wanderer.next())) << "seed " << seed << ", step " << i;
    ASSERT_EQ(ends.server.section(), ends.client.section());
    for (const Slot slot : ends.client.section().slots)
      ASSERT_EQ(ends.held.at(slot).height(), scene.zeroed()[slot].height()) << "seed " << seed << ", step " << i;
  }
  EXPECT_GT(ends.bits.pages_asked, 0u);
  std::printf("%.3f bits an added node, %.2f a page of %llu\n", ends.bits.pages / static_cast<double>(ends.bits.added),
              ends.bits.pages / static_cast<double>(ends.bits.pages_asked),
              static_cast<unsigned long long>(ends.bits.pages_asked));
}

INSTANTIATE_TEST_SUITE_P(Frames, SparseLevels, testing::Values(FrameKind::kPlanar, FrameKind::kGeographic));

}  // namespace
}  // namespace foreland::proto
