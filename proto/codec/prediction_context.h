// What both ends know around a node before they know its height: the vertices of the triangles that share its edge, and
// what these let one expect of its height and error. Its parents are in the section. Pure; any thread; portable.
#pragma once

#include <array>
#include <cstdint>
#include <cstdlib>

#include "proto/section/node_tables.h"
#include "proto/topology/grid.h"

namespace foreland::proto {

// In quanta. Heights are within kMaxHeight + 1, so that no sum overflows.
struct PredictionContext {
  int32_t ends = 0;              // sum of the edge's ends
  int32_t apex_difference = 0;   // sum of the triangles' apexes minus that of the ends
  int32_t parent_magnitude = 0;  // sum of the parents' displacements' sizes
  int32_t parent_sum = 0;        // sum of the parents' displacements

  // The expected error.
  double expected() const {
    return 0.25 * static_cast<double>(2 * int64_t{parent_magnitude} + std::abs(apex_difference)) + 0.25;
  }

  // Four times the displacement that a quadratic surface would have; real ones have three quarters of it.
  int32_t curve() const { return apex_difference + parent_sum; }
  // The expected height.
  int32_t guess() const { return (8 * ends + 3 * curve() + 8) >> 4; }

  // The vertices around a node. find() prefetches their records, so a caller that finds those of many nodes first does
  // not wait for each.
  struct Neighbours {
    std::array<VertexHeight, 2> ends, apexes;  // of a single apex, twice the same
  };
  // The neighbours of a node of a level. `nodes` is a table of node_tables.h.
  template <class Nodes>
  static Neighbours find(const GridTopology& grid, const Nodes& nodes, NodeId n, int level) {
    Neighbours neighbours;
    const auto [a, b] = grid.endpoints(n, level);
    neighbours.ends = {nodes.find(a), nodes.find(b)};
    const auto apexes = grid.apexes(n, level);
    for (int i = 0; i < apexes.count; ++i)  // those of level 1 are the centres of roots
      neighbours.apexes[static_cast<size_t>(i)] =
          level == 1 ? nodes.find(apexes.ids[i]) : VertexHeight{&nodes.at(grid.slot(apexes.ids[i], level - 1)), 0};
    if (apexes.count == 1) neighbours.apexes[1] = neighbours.apexes[0];
    for (const auto& vertices : {neighbours.ends, neighbours.apexes})
      for (const VertexHeight& v : vertices) __builtin_prefetch(v.record);
    return neighbours;
  }
  static PredictionContext of(const Neighbours& neighbours) {
    PredictionContext context;
    context.ends = neighbours.ends[0].height() + neighbours.ends[1].height();
    for (const VertexHeight& apex : neighbours.apexes) {
      context.apex_difference += apex.height();
      context.parent_magnitude += std::abs(apex.displacement());
      context.parent_sum += apex.displacement();
    }
    context.apex_difference -= context.ends;
    return context;
  }
};

// The nodes of a level by slot; quick for slots that ascend.
class LevelNodes {
 public:
  LevelNodes(const GridTopology& grid, int level)
      : grid_(grid), level_(level), first_(grid.levelOffset(level)), page_(grid.pageNodes(level, first_)) {}
  NodeId at(Slot slot) {
    if (slot - first_ >= kPageSlots) page_ = grid_.pageNodes(level_, first_ = slot & ~(kPageSlots - 1));
    return page_.at(static_cast<uint32_t>(slot - first_));
  }

 private:
  const GridTopology& grid_;
  int level_;
  Slot first_;
  GridTopology::PageNodes page_;
};

}  // namespace foreland::proto
