// Which entries of a planar terrain's frontier have another test result than they stand for, for one view: found for
// all of them in each step, in single precision, with a tolerance that holds whatever rounding does. An entry is surely
// as it was, surely changed, or unsure; only the unsure are tested exactly (terrain_batch.h), a few of a hundred
// thousand. So the answers that count are those of the exact test, on any machine.
//
// docs/decisions/0003-adaptation.md derives the tolerance. The arithmetic is plain floating point in a fixed order, for
// whatever vector instructions there are (base/vectors.h), with the same bits. Immutable while a view lasts; any
// thread.
#pragma once

#include <array>
#include <cstdint>

#include "base/vectors.h"
#include "proto/refine/memory/entry_pool.h"
#include "proto/refine/memory/slot_bits.h"
#include "proto/refine/metric/metric.h"
#include "proto/refine/metric/terrain_domain.h"

namespace foreland::proto {

// What a sweep does with entries of nodes that are left out as hidden, whose test says nothing.
enum class HiddenEntries : uint8_t { kLeave, kTest };

class Sweep {
 public:
  // The domain is planar. `tolerance` is a share of what is derived: 1 but for tests.
  Sweep(const TerrainDomain& domain, const Metric& metric, HiddenEntries hidden, double tolerance = 1);

  // Of a page's entries, by rank.
  struct Found {
    SlotBits changed, unsure;
  };
  // `first` is the page's first slot. `bits` and `heights` are columns of its entries, in whole vectors
  // (EntryPool::kVector). O(entries).
  Found test(int level, Slot first, const EntryBlock& block, const uint32_t* bits, const uint8_t* heights,
             Vectors vectors = widestVectors()) const;

 private:
  static constexpr size_t kRows = 5;  // to the right, up, depth, east, north, of a position relative to the eye

  // Of a page.
  struct Place {
    std::array<float, kRows> origin, along_x, along_y;  // of its middle, and of half a cell
    float radius, tolerance;                            // R in the metric's letters; what every tolerance has
  };
  template <bool kSides>
  struct Loop;
  Place placeOf(int level, Slot first, QuantisedRadius radius) const;

  const TerrainDomain& domain_;
  const HiddenEntries hidden_;
  std::array<std::array<double, 4>, kRows> row_;      // PlanarPositions, from the eye's height in quanta
  double region_radius_, step_x_, step_y_, quantum_;  // metres; steps are of the lattice
  double tolerance_;
  // As the loop takes them.
  struct Constants {
    std::array<float, 3> up;  // what a quantum of height adds to the first rows
    float eye_height, cos_angle, sin_angle, cos_corner, inverse_cos_corner, sin_x, cos_x, sin_y, cos_y, focal_over_tau,
        any_direction;
    float of_distance, of_error, of_side, of_steep;  // tolerances
  } k_;
};

}  // namespace foreland::proto
