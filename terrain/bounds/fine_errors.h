// The errors of PlanarError for the finest levels. Supports are too small there to scan one by one, so vector
// instructions run across neighbouring nodes instead. To make the samples of neighbours adjacent in memory, lattice
// rows are sorted by x modulo the period at which nodes repeat. Exact in doubles; a test demands equality with
// PlanarError. One owner.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/topology/grid.h"
#include "terrain/bounds/heights.h"
#include "terrain/bounds/node_row.h"

namespace foreland::terrain {

class FineErrors {
 public:
  static constexpr uint32_t kLargestReach = 8;  // of supports, in samples; PlanarError scans larger ones

  FineErrors(const proto::GridTopology& grid, const Heights& heights, const NodeLevel& level);

  // Writes the errors, in height quanta, of those nodes of the row whose supports lie within the data. Returns which
  // nodes of the row these are: [first, last).
  struct Range {
    uint32_t first = 0, last = 0;
  };
  Range compute(const NodeRow& row, std::span<double> errors);

 private:
  struct SortedRow {
    bool used = false;
    uint32_t y = 0;
    std::vector<int32_t> quanta;
  };
  const int32_t* sorted(uint32_t y);
  size_t sortedIndex(uint32_t x) const { return static_cast<size_t>(x % period_) * stride_ + x / period_; }
  void family(const NodeRow& row, uint32_t first, uint32_t every, uint32_t last, std::span<double> errors);

  const proto::GridTopology& grid_;
  Heights heights_;
  NodeLevel level_;
  uint32_t period_;  // samples
  size_t stride_;    // samples reserved for each remainder in a sorted row
  std::array<SortedRow, 2 * kLargestReach + 1> kept_;
  std::vector<double> family_errors_;
};

}  // namespace foreland::terrain
