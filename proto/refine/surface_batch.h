// Nodes of a surface that are tested together. Their records say all that the test takes, so no question is ever open:
// the least error that passes is any or none. A worker's own; too large to be copied about.
#pragma once

#include <array>
#include <cstdint>

#include "proto/refine/surface_domain.h"
#include "proto/section/bounds.h"

namespace foreland::proto {

struct SurfaceBatch {
  using Domain = SurfaceDomain;
  static constexpr size_t kSize = 256;

  size_t count = 0;
  std::array<Slot, kSize> slot;
  std::array<QuantisedError, kSize> bound;  // of no meaning
  std::array<SurfaceRecord, kSize> record;  // filled in by whoever has them
  // By the tests, as TerrainBatch has them.
  std::array<uint8_t, kSize> passes;
  std::array<float, kSize> slack;
  std::array<uint16_t, kSize> constraint;
  std::array<uint16_t, kSize> least;  // 0 if the node passes, 256 if not

  bool full() const { return count == kSize; }
  void push(NodeId, Slot s, int, QuantisedError b, float) {
    bound[count] = b;
    slot[count++] = s;
  }

  // Decodes the records, which the tests below take.
  void locate(const SurfaceDomain& domain, const SurfaceMetric& metric);
  void findLeast(const SurfaceMetric& metric);
  // `share` of each slack is taken.
  void testWithSlack(const SurfaceMetric& metric, const MotionBound& motion, double share);

 private:
  std::array<SurfaceBounds, kSize> bounds_;
  std::array<double, kSize> distance_;
};

}  // namespace foreland::proto
