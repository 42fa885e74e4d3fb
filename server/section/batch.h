// The refinement test for many nodes at once: plain loops over columns, which the compiler turns into vector
// instructions. Element by element the arithmetic is that of Metric, in the same order, so results are the same bits.
// One owner; fixed size, no allocation.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "server/section/places.h"

namespace foreland::server {

struct Batch {
  static constexpr size_t kSize = 256;

  size_t count = 0;
  std::array<int32_t, kSize> x, y;  // lattice
  std::array<proto::Slot, kSize> slot;
  std::array<int32_t, kSize> height;  // from here on filled by load()
  std::array<float, kSize> error, radius;
  std::array<uint8_t, kSize> passes;      // by test()
  std::array<float, kSize> slack, reach;  // by testWithSlack(): see there
  std::array<uint8_t, kSize> guard;       // Metric::Guard

  bool full() const { return count == kSize; }

  // Fetches the nodes' records.
  void load(const terrain::NodeRecord* nodes) {
    for (size_t i = 0; i < count; ++i) {
      const terrain::NodeRecord& record = nodes[slot[i]];
      height[i] = record.height;
      error[i] = record.error.metres();
      radius[i] = record.radius.metres();
    }
  }

  // Both are defined for PlanarPlaces and CurvedPlaces (batch.cpp), and called through the linker: inlined into a
  // caller that keeps batch and metric in one object, the compiler could not tell their memory apart and would not
  // vectorise.
  template <class Places>
  void test(const Metric& metric, const Places& places);

  // Also what each outcome is sure to survive, `share` of it, and the largest distance from the eye at which the place
  // can be while it does.
  template <class Places>
  void testWithSlack(const Metric& metric, const Places& places, double share);
};

}  // namespace foreland::server
