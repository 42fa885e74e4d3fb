// Nodes that are tested together, in columns, so that the test becomes vector instructions. A worker's own; too large
// to be copied about.
#pragma once

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
  std::array<QuantisedError, kSize> bound;  // what is tested
  std::array<int32_t, kSize> x, y;          // lattice
  std::array<int32_t, kSize> height;        // of the sphere's middle, steps
  std::array<float, kSize> radius;          // metres
  std::array<float, kSize> error;           // of `bound`; filled by the tests
  std::array<uint8_t, kSize> passes;        // by the tests
  // By testWithSlack(): how much motion each outcome is sure to survive, and the upper half of its entry (Entry::hold).
  std::array<float, kSize> slack;
  std::array<uint16_t, kSize> constraint;
  // By findLeast(): the least class of error with which each would pass; 256 if none does.
  std::array<uint16_t, kSize> least;

  bool full() const { return count == kSize; }

  // The node's name alone; the rest is left to be filled in.
  void push(NodeId n, Slot s, int at_level) {
    slot[count] = s;
    level[count] = static_cast<uint8_t>(at_level);
    x[count] = static_cast<int32_t>(n.x());
    y[count++] = static_cast<int32_t>(n.y());
  }
  void push(NodeId n, Slot s, int at_level, QuantisedError b, float radius_m) {
    bound[count] = b;
    radius[count] = radius_m;
    push(n, s, at_level);
  }

  void test(const TerrainDomain& domain, const Metric& metric);

  // Finds the places, which the tests below take.
  void locate(const TerrainDomain& domain, const Metric& metric);
  void findLeast(const Metric& metric);
  // `share` of each slack is taken. `motion` is the step's, and guards are chosen to last at its pace.
  void testWithSlack(const Metric& metric, const MotionBound& motion, double share);

 private:
  Metric::Place place(size_t i) const { return {right_[i], up_[i], depth_[i], horizontal_[i]}; }
  void lookUpErrors() {
    for (size_t i = 0; i < count; ++i) error[i] = bound[i].metres();
  }

  std::array<double, kSize> right_, up_, depth_, horizontal_;  // Metric::Place
};

}  // namespace foreland::proto
