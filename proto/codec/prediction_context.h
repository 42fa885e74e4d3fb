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

  // The vertices around a node. All that find some prefetch their records, so a caller that finds those of many nodes
  // first does not wait for each.
  using Vertices = std::array<VertexHeight, 2>;
  struct Neighbours {
    Vertices ends, apexes;  // of a single apex, twice the same
  };
  // The neighbours of a node of a level. `nodes` is a table of node_tables.h.
  template <class Nodes>
  static Neighbours find(const GridTopology& grid, const Nodes& nodes, NodeId n, int level) {
    return {findEnds(grid, nodes, n, level), findApexes(grid, nodes, n, level)};
  }
  template <class Nodes>
  static Vertices findEnds(const GridTopology& grid, const Nodes& nodes, NodeId n, int level) {
    const auto [a, b] = grid.endpoints(n, level);
    return prefetched({nodes.find(a), nodes.find(b)});
  }
  template <class Nodes>
  static Vertices findApexes(const GridTopology& grid, const Nodes& nodes, NodeId n, int level) {
    Vertices found;
    const auto apexes = grid.apexes(n, level);
    for (int i = 0; i < apexes.count; ++i)  // those of level 1 are the centres of roots
      found[static_cast<size_t>(i)] =
          level == 1 ? nodes.find(apexes.ids[i]) : VertexHeight{&nodes.at(grid.slot(apexes.ids[i], level - 1)), 0};
    if (apexes.count == 1) found[1] = found[0];
    return prefetched(found);
  }
  // The same for many nodes of a level above 1.
  template <class Nodes>
  static Vertices findApexes(const GridTopology::ApexSlots& apexes, const Nodes& nodes, NodeId n) {
    const auto [a, b] = apexes.of(n);
    return prefetched({VertexHeight{&nodes.at(a), 0}, VertexHeight{&nodes.at(b), 0}});
  }
  static PredictionContext of(const Neighbours& neighbours) {
    return of(neighbours.ends[0].height() + neighbours.ends[1].height(), neighbours.apexes);
  }
  // `ends` is the sum of their heights.
  static PredictionContext of(int32_t ends, const Vertices& apexes) {
    PredictionContext context;
    context.ends = ends;
    for (const VertexHeight& apex : apexes) {
      context.apex_difference += apex.height();
      context.parent_magnitude += std::abs(apex.displacement());
      context.parent_sum += apex.displacement();
    }
    context.apex_difference -= context.ends;
    return context;
  }

 private:
  static Vertices prefetched(const Vertices& found) {
    for (const VertexHeight& v : found) __builtin_prefetch(v.record);
    return found;
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
