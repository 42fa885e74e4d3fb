// Fills the node table: height, exact saturated error and saturated sphere of every node (THEORY section 3).
//
//   error(n)   at least the error of leaving n out (error.h), and at least the error of each child. 0 where the support
//              holds no data
//   radius(n)  of a sphere about the middle of n's edge; at least, for each child c, the distance to the middle of c's edge
//              plus radius(c) + 1e-5 m, so a viewer's distance test is monotone in floating point too; and at least the
//              distance to each sample of the support, hence to every point of the true and of any coarser surface there
//
// Level by level from the finest, in bands of tiles over `threads` threads; the result does not depend on their number.
#pragma once

#include <functional>
#include <span>

#include "proto/space/frame_grid.h"
#include "proto/space/geographic_tables.h"
#include "proto/topology/grid.h"
#include "terrain/bounds/heights.h"
#include "terrain/store/scene.h"

namespace foreland::terrain {

struct BoundsJob {
  const proto::GridTopology& grid;
  const proto::Frame& frame;
  Heights heights;
  // In scenes that change in time, the lowest and highest height of each sample at any time: spheres hold the surface
  // at all of them. Otherwise empty.
  Heights lowest{}, highest{};
  // By slot, errors that the nodes' must not be below; empty: none.
  std::span<const proto::QuantisedError> min_errors{};
  // What heights were rounded by makes of an error at most; errors are larger by as much. Metres.
  double rounding_m = 0;
  // By slot, the errors themselves, before they are saturated; empty: those of the heights.
  std::span<const proto::QuantisedError> raw_errors{};
  // The finest level that is computed, if not the grid's: `nodes` has the records of those below it.
  int from_level = proto::GridTopology::kMaxLevels;
  // Of a lattice that is a part of a larger one, or has only some of its points: the larger one's spheres of this one's
  // levels, and its tables at this one's rows and columns. Null: those of `grid`.
  const proto::SphereLevels* spheres = nullptr;
  const proto::GeographicTables* tables = nullptr;
  // Only nodes whose supports reach a lattice row from first_row to last_row get errors; the others' are zero.
  uint32_t first_row = 0, last_row = 0xffffffff;
  std::span<const NodeRecord> nodes;  // slotCount() records, in which what `store` is given appears
  unsigned threads = 0;               // 0: one per processor
  // Called from any thread, once for each slot, with whole tiles and zeros in their padding. False stops the work.
  std::function<bool(proto::Slot first, std::span<const NodeRecord>)> store;
  // Called from any thread with a range of `nodes` that will not be read for a while, so its pages may leave memory.
  std::function<void(std::span<const NodeRecord>)> onIdle = [](std::span<const NodeRecord>) {};
  // Called on the calling thread with the fraction done. False stops the work.
  std::function<bool(double)> onProgress = [](double) { return true; };
};

// False if `store` or `onProgress` stopped it.
[[nodiscard]] bool computeBounds(const BoundsJob& job);

}  // namespace foreland::terrain
