// The grids whose sections are fuzzed: the first byte of an input selects the grid (modulo how many there are).
#pragma once

#include <array>

#include "proto/topology/grid.h"

namespace foreland::test {

// The smallest grid; roots that the data does not fill; one deep root.
inline const std::array<proto::GridTopology, 3>& sectionGrids() {
  using proto::GridTopology;
  static const std::array<GridTopology, 3> grids{*GridTopology::create({1, 1, 1, 3, 3}),
                                                 *GridTopology::create({2, 3, 5, 60, 97}),
                                                 *GridTopology::create({1, 1, 10, 1025, 1025})};
  return grids;
}

}  // namespace foreland::test
