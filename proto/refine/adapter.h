// An adapter moves from the previous section to the next at a cost that follows the changes. Only the frontier can
// change: the leaves, which can be removed, and the nodes that can be added. On planar terrain a step tests all of them
// in single precision, page by page, and exactly those of which that leaves a doubt (sweep.h). On curved frames and on
// surfaces each entry has a slack: the motion that its last result is sure to survive (motion_margin.h). There a step
// subtracts its motion from every slack, and tests again only the nodes whose slack is used up. Either way the result
// equals refine(), node for node, for any motion.
//
// S 3.4 moves the cut by testing all of it; sweep and slack are ours.
//
// Both ends run the adapter: the server on the scene's records, the client on what it is sent. Terrain and surfaces
// differ in their tester only: terrain_tester.h decides by bounds on errors, and by predicates where the bounds leave a
// test open; surface_tester.h decides by records. A node that leaves the frontier is forgotten, so what an adapter
// knows is a function of the section and of the views since.
//
// An adapter has one owner (a session, a replica). It allocates nothing once it has grown to the section's size.
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

  // The adapter begins with the empty section.
  explicit Adapter(const Domain& domain) : domain_(&domain), frontier_(Tester::entryKind(domain)), memory_(domain) {}
  // The adapter begins with `section`, which is closed and of whose nodes' errors nothing is known. The source gives
  // the radii of the section's pages.
  Adapter(const Domain& domain, std::span<const Slot> section, Source& source);
  // Says what both ends know of pages. May be called right after the constructor that takes a section. `pages` are
  // ascending and hold all of the section's nodes; pages without such nodes are remembered, the coarsest longest.
  void learn(std::span<const KnownPage> pages);
  // Begins with the empty section again. `remembered` says whether every page is remembered, or none; pages that were
  // in use are treated like the others.
  void restart(Remembered remembered);
  // Live pages have nodes in the section or on its frontier. Known pages are the live ones and those that are
  // remembered. Both results are ascending.
  std::vector<KnownPage> livePages() const;
  std::vector<KnownPage> knownPages() const;

  // Moves to the section of `view` and appends what changed to `delta`, ascending. The result is false if the section
  // would exceed `max_nodes` or the source stopped; the adapter must not be used after that.
  [[nodiscard]] bool adapt(const View& view, size_t max_nodes, Source& source, AdaptScratch& scratch, CutDelta& delta);

  size_t nodeCount() const { return nodes_in_section_; }
  Section section() const;
  bool contains(Slot slot) const { return frontier_.nodes().isInSection(slot); }
  // Calls visit(slot) for one in `every` of the section's nodes, ascending and evenly.
  template <class Visit>
  void sampleSection(uint32_t every, const Visit& visit) const {
    frontier_.nodes().sampleSection(every, visit);
  }
  // The radius of the slot's page, and the set of its nodes that are known; both are empty if nothing is remembered of
  // the page.
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
  // The tester's memory lasts from step to step.
  const typename Tester::Memory& memory() const { return memory_; }
  typename Tester::Memory& memory() { return memory_; }
  size_t bytes() const { return frontier_.bytes() + memory_.bytes(); }
  size_t frontierSize() const { return frontier_.entryCount(); }
  uint64_t testCount() const { return tests_; }   // Exact tests are counted from the start,
  uint64_t sweptCount() const { return swept_; }  // and entries that were swept.
  // CHECKs that the section is closed and that exactly its frontier nodes have an entry. Tests call it; it is O(scene).
  void validate() const;

 private:
  class Step;
  MotionBound motionBoundTo(const View& view) const;

  const Domain* domain_;
  Frontier frontier_;
  typename Tester::Memory memory_;
  std::optional<View> last_;
  bool is_complete_ = false;  // The whole frontier has entries, as it has after any step.
  size_t nodes_in_section_ = 0;
  uint64_t tests_ = 0, swept_ = 0;
  uint32_t steps_ = 0;
};

using TerrainAdapter = Adapter<TerrainTester>;
using SurfaceAdapter = Adapter<SurfaceTester>;

// KnownNodes says which nodes an adapter knows. The adapter must not be stepped while a KnownNodes is in use. has() is
// O(1), and looks a page up once for all of its slots that are asked about in a row.
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
  uint32_t page_ = kNoSlot;  // No page has so large a number.
  SlotBits known_;
};

}  // namespace foreland::proto
