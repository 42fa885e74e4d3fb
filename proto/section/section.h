// A section is a parent-closed set of nodes: one view-dependent mesh. Here it is a plain sorted array of slots; slots
// ascend with the level, so parents stand before their children. A cut delta is what turns one section into another.
// Pure functions on plain data; any thread.
#pragma once

#include <span>
#include <vector>

#include "base/result.h"
#include "proto/topology/grid.h"

namespace foreland::proto {

struct Section {
  std::vector<Slot> slots;  // ascending, unique
  bool operator==(const Section&) const = default;
};

struct CutDelta {
  std::vector<Slot> added;    // ascending
  std::vector<Slot> removed;  // ascending, disjoint from added
  bool operator==(const CutDelta&) const = default;
};

// O(log n).
bool contains(const Section& section, Slot slot);

// An Error names the first slot that is out of order, no node, or without one of its parents. O(n log n).
Status validate(const GridTopology& grid, const Section& section);

// The delta with apply(from, delta) == to. Reuses the vectors of `out`. O(n).
void diff(const Section& from, const Section& to, CutDelta& out);
// `delta` must fit: nothing added twice, nothing removed that is not there. O(n).
Section apply(const Section& from, const CutDelta& delta);

// A fingerprint that does not depend on order: both ends keep it up to date node by node and compare it at each
// keyframe.
uint32_t fingerprint(Slot slot);
uint32_t fingerprint(std::span<const Slot> slots);

}  // namespace foreland::proto
