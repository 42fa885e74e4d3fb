// What both ends know around a node whose parents are there, before they know the node: where its edge lies, and what
// that lets one expect of it. Pure; any thread; portable.
#pragma once

#include <cstdint>
#include <cstdlib>

#include "proto/bounds.h"
#include "proto/grid.h"

namespace foreland::proto {

// Steps. Heights are within kMaxHeight + 1, so that no sum overflows.
struct Surroundings {
  int32_t ends = 0;      // sum of the edge's ends
  int32_t twist = 0;     // sum of the triangles' apexes minus that of the ends
  int32_t bends = 0;     // sum of the parents' displacements' sizes
  int32_t together = 0;  // sum of the parents' displacements

  // A guess at the error.
  double expected() const { return 0.25 * static_cast<double>(2 * int64_t{bends} + std::abs(twist)) + 0.25; }

  // Four times the displacement that a quadratic surface would have; real ones have three quarters of it.
  int32_t curve() const { return twist + together; }
  // At the height.
  int32_t guess() const { return (8 * ends + 3 * curve() + 8) >> 4; }

  // Of a node of a level. `nodes` is a table of node_tables.h.
  template <class Nodes>
  static Surroundings of(const GridTopology& grid, const Nodes& nodes, NodeId n, int level) {
    Surroundings around;
    const auto [a, b] = grid.endpoints(n);
    around.ends = nodes.height(a) + nodes.height(b);
    const auto apexes = grid.apexes(n);
    for (NodeId apex : apexes) {
      if (level == 1) {  // the centres of roots
        around.twist += nodes.height(apex);
        continue;
      }
      const NodeRecord& record = nodes.at(grid.slot(apex, level - 1));
      around.twist += record.height();
      around.bends += std::abs(record.displacement());
      around.together += record.displacement();
    }
    if (apexes.count == 1) around.twist *= 2, around.bends *= 2, around.together *= 2;
    around.twist -= around.ends;
    return around;
  }
};

// The nodes of a level by slot; quick for slots that ascend.
class LevelNodes {
 public:
  LevelNodes(const GridTopology& grid, int level)
      : grid_(grid), level_(level), first_(grid.levelOffset(level)), page_(grid.pageNodes(level, first_)) {}
  NodeId at(Slot slot) {
    if (slot - first_ >= kPageSlots) page_ = grid_.pageNodes(level_, first_ = slot & ~(kPageSlots - 1));
    return page_.at(slot - first_);
  }

 private:
  const GridTopology& grid_;
  int level_;
  Slot first_;
  GridTopology::PageNodes page_;
};

}  // namespace foreland::proto
