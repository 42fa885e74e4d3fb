// Relief of scenes that are fine in places only, and what bounds their ground: what relief.h and ground_bounds.h do of
// whole ones, in time and memory of the nodes that are there. Their heights between nodes are those of the drawn
// triangles, not rounded.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "base/result.h"
#include "proto/imagery/tile.h"
#include "proto/space/frame_grid.h"
#include "terrain/imagery/relief.h"
#include "terrain/store/stored_heights.h"
#include "terrain/store/tables/tile_section.h"

namespace foreland::terrain {

class SparseGroundBounds {
 public:
  // `ground` must outlive it; `frame` has the height quantum. O(columns + rows).
  SparseGroundBounds(const StoredHeights& ground, const proto::Frame& frame);

  // As GroundBounds::over(), on a globe of a box on one face; also of heights between nodes that are rounded to whole
  // quanta. Any thread. Memory: 24 MB at most.
  proto::TileBounds over(const proto::LatticeBox& box) const;

 private:
  template <class Visit>
  void forEachWindow(const proto::LatticeBox& box, const Visit& visit) const;
  template <class See, class Visit>
  void forEachNormal(const proto::LatticeBox& box, const See& see, const Visit& visit) const;

  const StoredHeights& ground_;
  double height_quantum_m_, rounding_rad_;
  proto::FrameGrid positions_;
};

// Adds as a layer the tiles of relief that show more than their parents: those of a level whose nodes are there in a
// part of them, and all of coarser levels. Memory: four bytes a texel of two levels' tiles. As addRelief().
Result<bool> addSparseRelief(const StoredHeights& ground, const SparseGroundBounds& bounds, const proto::Frame& frame,
                             unsigned threads, const KeepGoing& keepGoing, TileSection& section);

}  // namespace foreland::terrain
