// A section of a surface and its frontier, as sets of slots: what both ends hold of an object that is sent, and what
// the coder walks over (surface_codec.h). On the frontier are the leaves (nodes of the section without a child in it)
// and the addable nodes (not in it, all their parents in it). The adapter has the same sets with the slack of tests
// beside them; here nothing is tested.
//
// In pages of 256 slots, of one level each; a page lives while it holds something. One owner; portable to WebAssembly.
// A change costs a few look-ups, of O(log pages) each; memory is linear in the section.
#pragma once

#include <map>

#include "proto/refine/slot_bits.h"
#include "proto/section/section.h"
#include "proto/topology/mesh_topology.h"

namespace foreland::proto {

class SurfaceCut {
 public:
  struct Page {
    SlotBits in_section, on_frontier;
    SlotBits added, removed;  // in the step under way
    SlotBits leaves() const { return on_frontier & in_section; }
    // What has gone in this step does not come again in it.
    SlotBits addable() const { return on_frontier - in_section - removed; }
    bool isEmpty() const { return !in_section.any() && !on_frontier.any(); }
  };
  using Pages = std::map<uint32_t, Page>;  // by slot >> 8; an iterator holds while others come

  // Empty; `mesh` must outlive it.
  explicit SurfaceCut(const MeshTopology& mesh) : mesh_(&mesh) {}

  const MeshTopology& mesh() const { return *mesh_; }
  bool contains(Slot slot) const;
  bool wasAdded(Slot slot) const;  // in the step under way
  size_t nodeCount() const { return nodes_; }
  Section section() const;  // ascending
  // Pages of a level begin here and end with the level's slots.
  Pages::iterator firstPageOf(int level) { return pages_.lower_bound(mesh_->levelOffset(level) / kPageSlots); }
  Pages::iterator end() { return pages_.end(); }

  // Instead of what it was; closed.
  void hold(const Section& section);

  // A step: first nodes go, from the finest level to the coarsest, then nodes come, the other way. O(base mesh) once.
  void beginStep();
  void remove(Pages::iterator page, uint8_t low);  // of the leaves
  void add(Pages::iterator page, uint8_t low);     // of the addable nodes
  void endStep();

  // CHECKs that the section is closed and its frontier is listed. O(slots); for tests.
  void validate() const;

 private:
  struct At {
    NodeId node;
    int level;
  };
  At nodeAt(uint32_t key, uint8_t low) const;
  bool hasChild(NodeId n, int level) const;
  void list(Slot slot);
  void unlist(Slot slot);

  const MeshTopology* mesh_;
  Pages pages_;
  size_t nodes_ = 0;
  bool is_seeded_ = false;  // the nodes without parents are on the frontier
};

}  // namespace foreland::proto
