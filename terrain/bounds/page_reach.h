// How far the nodes of a page are from their children, page by page. All nodes of a page have one radius, and rounding
// keeps order, so a page's radius follows from these distances and the radii of the pages that hold the children, to
// the bit as bounds.h computes it; and the distances follow from heights nearby alone, so that blocks of a lattice can
// be measured apart. Pure; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/section/bounds.h"
#include "proto/topology/grid.h"
#include "terrain/bounds/heights.h"
#include "terrain/bounds/spheres.h"

namespace foreland::terrain {

// Metres to the furthest child in each page of the next level that holds any: of centres, the page itself and those
// east and north of it; of sides, those of the two tiles below it, and west and south of these. Negative: no child is
// there. Of the finest level, to the furthest sample of the support, in the first place.
struct PageReach {
  static constexpr size_t kPages = 6;
  std::array<double, kPages> metres;
};

// Pages of one level: the columns and rows [first, last) of PagePlace.
struct PageWindow {
  int level = 1;
  uint32_t first_column = 0, last_column = 0, first_row = 0, last_row = 0;
  uint32_t columns() const { return last_column - first_column; }
  size_t count() const { return size_t{columns()} * (last_row - first_row); }
};

// Row by row. `positions` must know heights as far from the pages' nodes as the nodes' children are, and these edges.
// `extremes` have samples that spheres must hold, too, as SphereRows has them.
std::vector<PageReach> reachOf(const proto::GridTopology& grid, const RowPositions& positions,
                               std::span<const RowPositions> extremes, const PageWindow& pages);

// The radius of a page at a place; radiusOf(its column, its row) is that of a page of the next level.
template <class RadiusOf>
proto::QuantisedRadius pageRadius(const proto::GridTopology& grid, const proto::SphereLevels& levels,
                                  const proto::PagePlace& page, const PageReach& reach, const RadiusOf& radiusOf) {
  const bool sides = page.level & 1;
  double radius_m = 0;
  for (size_t i = 0; i < PageReach::kPages; ++i) {
    if (reach.metres[i] < 0) continue;
    const auto k = static_cast<uint32_t>(i);
    double below_m = 0;
    if (page.level < grid.maxLevel()) {
      const uint32_t column = sides ? 2 * page.column + k % 3 - 1 : page.column + k % 2,
                     row = sides ? page.row + k / 3 - 1 : 2 * page.row + k / 2;
      below_m = static_cast<double>(levels.radius(page.level + 1, radiusOf(column, row)));
    }
    radius_m = std::max(radius_m, reach.metres[i] + below_m);
  }
  return levels.roundUp(page.level, radius_m + kSpherePad_m);
}

}  // namespace foreland::terrain
