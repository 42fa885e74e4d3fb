// The same errors as PlanarError, for the finest levels, where supports are too small to scan one by one: the
// compiler's vectors run across neighbouring nodes instead. To make neighbours adjacent in memory, lattice rows are
// sorted by x modulo the period at which nodes repeat. Exact, in doubles; a test demands equality with PlanarError. One
// owner.
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
  static constexpr uint32_t kLargestReach = 8;  // beyond, rows of supports are long enough to scan

  FineErrors(const proto::GridTopology& grid, const Heights& heights, const NodeLevel& level);

  // Errors in steps of the row's nodes whose supports lie within the data; returns which: [first, last) of the row.
  struct Range {
    uint32_t first = 0, last = 0;
  };
  Range compute(const NodeRow& row, std::span<double> steps);

 private:
  struct SortedRow {
    bool used = false;
    uint32_t y = 0;
    std::vector<int32_t> steps;
  };
  const int32_t* sorted(uint32_t y);
  size_t place(uint32_t x) const { return static_cast<size_t>(x % period_) * stride_ + x / period_; }
  void family(const NodeRow& row, uint32_t first, uint32_t every, uint32_t last, std::span<double> steps);

  const proto::GridTopology& grid_;
  Heights heights_;
  NodeLevel level_;
  uint32_t period_;  // samples
  size_t stride_;    // of one remainder within a sorted row
  std::array<SortedRow, 2 * kLargestReach + 1> kept_;
  std::vector<double> family_errors_;
};

}  // namespace foreland::terrain
