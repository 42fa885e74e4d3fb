// The refinement test for many nodes at once: plain loops over columns, which the compiler turns into vector
// instructions. Element by element the arithmetic is that of Metric, in the same order, so results are the same bits.
// One owner; fixed size, no allocation.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "proto/refine/metric.h"
#include "proto/refine/terrain_domain.h"

namespace foreland::proto {

struct TerrainBatch {
  using Domain = TerrainDomain;
  static constexpr size_t kSize = 256;

  size_t count = 0;
  std::array<Slot, kSize> slot;
  std::array<uint8_t, kSize> level;
  std::array<ErrorClass, kSize> bound;    // what is tested
  std::array<int32_t, kSize> x, y;        // lattice
  std::array<int32_t, kSize> height;      // of the sphere's middle, steps
  std::array<float, kSize> radius;        // metres
  std::array<float, kSize> error;         // of `bound`; filled by the tests
  std::array<uint8_t, kSize> passes;      // by test()
  std::array<float, kSize> slack, reach;  // by testWithSlack(): see there
  std::array<uint8_t, kSize> guard;       // Metric::Guard
  std::array<uint16_t, kSize> least;      // by findLeast()

  bool full() const { return count == kSize; }

  // The node's name alone; the rest is left to be filled in.
  void push(NodeId n, Slot s, int at_level) {
    slot[count] = s;
    level[count] = static_cast<uint8_t>(at_level);
    x[count] = static_cast<int32_t>(n.x());
    y[count++] = static_cast<int32_t>(n.y());
  }
  void push(NodeId n, Slot s, int at_level, ErrorClass b, float radius_m) {
    bound[count] = b;
    radius[count] = radius_m;
    push(n, s, at_level);
  }

  void test(const TerrainDomain& domain, const Metric& metric);

  // Also what each outcome is sure to survive, `share` of it, and the largest distance from the eye at which the place
  // can be while it does.
  void testWithSlack(const TerrainDomain& domain, const Metric& metric, double share);

  // The least class of error with which each would pass; 256 if none does.
  void findLeast(const TerrainDomain& domain, const Metric& metric);

 private:
  void lookUpErrors() {
    for (size_t i = 0; i < count; ++i) error[i] = bound[i].metres();
  }
};

}  // namespace foreland::proto
