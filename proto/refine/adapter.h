// From the previous section to the next at a cost that follows the changes. Only the frontier (leaves, which can be
// removed, and nodes that can be added) can change, and the test of a frontier node only once the camera has moved far
// enough: each entry has a slack, the motion that its last result is sure to survive (motion_margin.h). A step
// subtracts its motion from every slack, page by page, and tests again only the nodes whose slack is used up. The
// result equals refine(), node for node, for any motion.
//
// S 3.4 moves the cut by testing all of it; the slack is ours.
//
// Both ends run it: the server on the scene's records, the client on what it is sent. This file steps the frontier.
// What differs between terrain and surfaces is their tester: terrain_tester.h decides by bounds on errors and by
// predicates that its source decides, surface_tester.h by records. A node that leaves the frontier is forgotten: what
// is known is a function of the section and of the views since.
//
// One owner (a session, a replica). No allocation once grown to the section's size.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "proto/refine/adapt_scratch.h"
#include "proto/refine/frontier.h"
#include "proto/refine/surface_tester.h"
#include "proto/refine/terrain_tester.h"
#include "proto/section/section.h"

namespace foreland::proto {

template <class Tester>
class Adapter {
 public:
  using Domain = typename Tester::Domain;
  using Source = typename Tester::Source;

  // Begins with the empty section.
  explicit Adapter(const Domain& domain) : domain_(&domain), memory_(domain) {}
  // Begins with a closed section; nothing is known of its nodes' errors. The source gives the radii of its pages.
  Adapter(const Domain& domain, std::span<const Slot> section, Source& source);
  // Right after that: both ends also know this of pages, which are ascending and hold all of the section's nodes. Those
  // without any are remembered, the coarsest longest.
  void learn(std::span<const KnownPage> pages);
  // Begins with the empty section again. Pages that were in use are remembered like the others, or none is.
  void restart(Remembered remembered);
  // What is known of pages with nodes in the section or on its frontier; of these and those that are remembered.
  // Ascending.
  std::vector<KnownPage> livePages() const;
  std::vector<KnownPage> knownPages() const;

  // Moves to the section of `view` and appends what changed to `delta`, ascending. False if the section would exceed
  // `max_nodes` or the source stopped: the adapter must not be used after that.
  [[nodiscard]] bool adapt(const View& view, size_t max_nodes, Source& source, AdaptScratch& scratch, CutDelta& delta);

  size_t nodeCount() const { return nodes_in_section_; }
  Section section() const;  // ascending
  bool contains(Slot slot) const { return frontier_.nodes().isInSection(slot); }
  // Of what has been said of the slot's page, if anything is remembered: its radius, and which of its nodes are known.
  std::optional<QuantisedRadius> radius(Slot slot) const {
    const uint32_t page = frontier_.nodes().find(slot);
    return page == Frontier::Nodes::kNone ? memory_.radius(slot) : frontier_.nodes().page(page).knowledge.radius;
  }
  SlotBits known(Slot slot) const {
    const uint32_t page = frontier_.nodes().find(slot);
    return page == Frontier::Nodes::kNone ? memory_.known(slot) : frontier_.nodes().page(page).knowledge.known;
  }
  // Whether any of the 64 slots from `first` on, a multiple of 64, is in the section, on its frontier or known.
  bool knowsBlock(Slot first) const {
    const uint32_t page = frontier_.nodes().find(first);
    if (page == Frontier::Nodes::kNone) return memory_.knowsAnyOf64(first);
    return frontier_.nodes().page(page).knowledge.knowsAnyOf64(first) || frontier_.nodes().hasAnyOf64(first);
  }
  // What the tester remembers from step to step.
  const typename Tester::Memory& memory() const { return memory_; }
  typename Tester::Memory& memory() { return memory_; }
  size_t bytes() const { return frontier_.bytes() + memory_.bytes(); }  // memory of this session's state
  size_t frontierSize() const { return frontier_.entryCount(); }
  uint64_t testCount() const { return tests_; }  // nodes tested since the start
  // CHECKs that the section is closed and that exactly its frontier nodes have an entry. O(scene); for tests.
  void validate() const;

 private:
  class Step;
  MotionBound motionBoundTo(const View& view) const;

  const Domain* domain_;
  Frontier frontier_;
  typename Tester::Memory memory_;
  std::optional<View> last_;
  bool is_complete_ = false;  // the whole frontier has entries, as after any step
  size_t nodes_in_section_ = 0;
  uint64_t tests_ = 0;
  uint32_t steps_ = 0;
};

using TerrainAdapter = Adapter<TerrainTester>;
using SurfaceAdapter = Adapter<SurfaceTester>;

// Whether nodes are known to an adapter, which must not be stepped meanwhile: O(1), and a page is looked up once for
// the slots of it that are asked about in a row.
class KnownNodes {
 public:
  explicit KnownNodes(const TerrainAdapter& adapter) : adapter_(adapter) {}
  bool has(Slot slot) {
    if (slot / kPageSlots != page_) {
      page_ = slot / kPageSlots;
      known_ = adapter_.known(slot);
    }
    return known_.has(lowOf(slot));
  }

 private:
  const TerrainAdapter& adapter_;
  uint32_t page_ = kNoSlot;  // no page has so large a number
  SlotBits known_;
};

}  // namespace foreland::proto
