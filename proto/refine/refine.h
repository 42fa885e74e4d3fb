// Refinement from scratch: the section of a view, level by level. A node is in the section if it and all its ancestors
// pass the test of metric.h; since the test grows towards the parents, that is simply every node that passes. This is
// the reference that incremental adaptation must equal, node for node. Pure function of its arguments and scratch; any
// thread; no allocation once the scratch has grown. Cost: one test per triangle.
#pragma once

#include <span>
#include <vector>

#include "proto/refine/hidden/hidden_blocks.h"
#include "proto/refine/metric/metric.h"
#include "proto/refine/metric/terrain_domain.h"
#include "proto/section/node_tables.h"
#include "proto/section/section.h"

namespace foreland::proto {

struct LatticePoint {
  int32_t x, y;
};

// Which nodes may be read, of a scene that is not all there (terrain/store/distant). Of one that may not be, nothing is
// read, and it is taken not to pass.
class ReadableNodes {
 public:
  virtual bool isReadable(Slot slot) = 0;

 protected:
  ~ReadableNodes() = default;
};

// A worker's own; reused from call to call.
struct RefineScratch {
  std::vector<Slot> slots, sorted;
  std::vector<LatticePoint> in_section, next;
};

// Fills `section` (ascending slots). False, with `section` unspecified, if it would hold more than `max_nodes`.
// Nodes that are known to be hidden are left out, if `hidden` is given. Of each node that a parent in the section leads
// to, `readable` is asked first, if it is given.
[[nodiscard]] bool refine(const TerrainDomain& domain, const StoredNodes& nodes, const View& view, size_t max_nodes,
                          RefineScratch& scratch, Section& section, const HiddenBlocks* hidden = nullptr,
                          ReadableNodes* readable = nullptr);

// The size of a section, as a sample says; lab/README.md has its errors.
struct SampledSize {
  double nodes = 0;
  double within = 0;  // of these, nodes that a smaller section has as well
  size_t sample = 0;  // nodes that it is told from, which is what it costs
};
// About how many nodes refine() finds for `view`, and for `inner`, which needs no others. It follows one of two of a
// level's nodes where the level has many, so that it finds at most some ten thousand of any section's.
[[nodiscard]] SampledSize estimateSize(const TerrainDomain& domain, const StoredNodes& nodes, const View& view,
                                       const View& inner, RefineScratch& scratch, const HiddenBlocks* hidden = nullptr,
                                       ReadableNodes* readable = nullptr);
// How many of some nodes a section for `view` has, hidden ones included.
[[nodiscard]] size_t countNeeded(const TerrainDomain& domain, const StoredNodes& nodes, const View& view,
                                 std::span<const Slot> slots);

// Triangles of a section's mesh before clipping: 4 per root, one more per border node, two more per other node.
size_t triangleCount(const GridTopology& grid, const Section& section);

}  // namespace foreland::proto
