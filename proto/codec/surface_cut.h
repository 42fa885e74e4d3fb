// A section of a surface and its frontier, as sets of slots (refine/paged_nodes.h): what both ends hold of an object
// that is sent, and what the coder walks over (surface_codec.h). An adapter holds the same sets with the slack of tests
// beside them; here nothing is tested.
//
// One owner; portable to WebAssembly. A change costs a few look-ups; memory is linear in the section.
#pragma once

#include <span>

#include "proto/refine/memory/paged_nodes.h"
#include "proto/section/section.h"
#include "proto/topology/mesh_topology.h"

namespace foreland::proto {

class SurfaceCut {
 public:
  struct Page : NodePage {
    SlotBits added, removed;  // in the current step
    SlotBits leaves() const { return on_frontier & in_section; }
    // A node that was removed in this step is not added again in it.
    SlotBits addable() const { return on_frontier - in_section - removed; }
  };
  using Pages = PagedNodes<Page>;

  // Empty; `mesh` must outlive it.
  explicit SurfaceCut(const MeshTopology& mesh) : mesh_(&mesh) {}

  const MeshTopology& mesh() const { return *mesh_; }
  bool contains(Slot slot) const { return pages_.isInSection(slot); }
  bool wasAdded(Slot slot) const { return pages_.pageAt(slot).added.has(lowOf(slot)); }  // in the current step
  size_t nodeCount() const { return nodes_; }
  Section section() const;  // ascending
  const Page& page(uint32_t number) const { return pages_.page(number); }
  // The pages of a level, ascending; while only nodes of this level are added or removed.
  std::span<const Pages::PageName> pagesOf(int level);

  // Replaces the section by another, which is closed.
  void hold(const Section& section);

  // A step: first nodes are removed, from the finest level to the coarsest, then nodes are added, from the coarsest to
  // the finest. Costs O(base mesh) once, and O(pages) each time.
  void beginStep();
  void remove(uint32_t page, uint8_t low);  // one of the leaves
  void add(uint32_t page, uint8_t low);     // one of the addable nodes
  void endStep();

  // CHECKs that the section is closed and that the frontier is complete. O(slots); for tests.
  void validate() const;

 private:
  struct At {
    NodeId node;
    int level;
  };
  At nodeAt(uint32_t page, uint8_t low) const;
  bool hasChild(NodeId n, int level) const;
  void addToFrontier(Slot slot);
  void removeFromFrontier(Slot slot);

  const MeshTopology* mesh_;
  Pages pages_;
  size_t nodes_ = 0;
  bool has_first_level_ = false;  // the nodes without parents are on the frontier
};

}  // namespace foreland::proto
