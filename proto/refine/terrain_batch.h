// Terrain nodes that are tested together, in columns, so that the test becomes vector instructions. A worker's own; too
// large to be copied.
#pragma once

#include <array>
#include <cstdint>

#include "base/vectors.h"
#include "proto/refine/memory/entry_pool.h"
#include "proto/refine/metric/metric.h"
#include "proto/refine/metric/motion_bound.h"
#include "proto/refine/metric/terrain_domain.h"

namespace foreland::proto {

struct TerrainBatch {
  using Domain = TerrainDomain;
  static constexpr size_t kSize = 256;
  static constexpr uint16_t kNonePasses = 256;

  size_t count = 0;
  std::array<Slot, kSize> slot;
  std::array<uint8_t, kSize> level;
  std::array<QuantisedError, kSize> bound;     // the error that is tested
  std::array<int32_t, kSize> x, y;             // lattice position
  std::array<int32_t, kSize> height;           // of the sphere's centre, height quanta
  std::array<QuantisedError, kSize> recorded;  // the node's error, where it is settled
  std::array<float, kSize> radius;             // of the sphere, metres
  std::array<float, kSize> error;              // `bound` in metres, by the tests
  std::array<uint8_t, kSize> passes;           // by the tests
  // By testWithSlack(): how much motion each result is sure to survive, and how motion is taken off it.
  std::array<float, kSize> slack;
  std::array<MotionConstraint, kSize> constraint;
  // By findLeast(): the least quantised error with which each node would pass; kNonePasses if there is none.
  std::array<uint16_t, kSize> least;

  bool full() const { return count == kSize; }

  // Sets the columns that follow from the node's name; the caller sets the others.
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

  void setRecord(size_t i, const NodeRecord& record) {
    height[i] = record.middle();
    recorded[i] = record.error();
  }

  void test(const TerrainDomain& domain, const Metric& metric, Vectors vectors = widestVectors());

  // Computes the nodes' positions, which the functions below need.
  void locate(const TerrainDomain& domain, const Metric& metric, Vectors vectors = widestVectors());
  void findLeast(const Metric& metric, Vectors vectors = widestVectors());
  // The least error with which node number `i` would pass, as if no horizon hid it; up to rounding, metres.
  double leastError(size_t i, const Metric& metric) const { return metric.minError(position(i), radius[i]); }
  // `motion` is the step's: the sensitivity of each result is the one that lasts longest at its pace.
  void testWithSlack(const Metric& metric, const MotionBound& motion, Vectors vectors = widestVectors());

 private:
  struct Loops;
  void limitByHorizon(const Horizon& horizon);
  // Calls use(positions) with those of a frame of this domain's kind.
  template <class Use>
  static void withPositions(const TerrainDomain& domain, const Metric& metric, const Use& use);
  NodePosition position(size_t i) const { return {{right_[i], up_[i], depth_[i]}, horizontal_[i]}; }
  void lookUpErrors() {
    for (size_t i = 0; i < count; ++i) error[i] = bound[i].metres();
  }

  std::array<double, kSize> right_, up_, depth_, horizontal_;  // NodePosition
};

}  // namespace foreland::proto
