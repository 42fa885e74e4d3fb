// The exact error of leaving one node out (THEORY section 3): the largest distance, over the data samples of the node's
// support, between the true surface and the surface without the node, at the same parameter. Not saturated; bounds.h
// does that.
//
//   planar      both points lie on the same vertical line, so the distance is vertical; exact
//   geographic  in space, curvature included; overstated by at most 1e-7 m, which covers rounding; less than
//               2e-8 m counts as nothing
//
// Immutable after construction; any thread. Cost: O(samples of the support), four samples at a time.
#pragma once

#include "proto/space/geographic_tables.h"
#include "proto/topology/grid.h"
#include "terrain/bounds/heights.h"

namespace foreland::terrain {

// The samples that count, both corners included.
struct ErrorWindow {
  uint32_t low_x = 0, low_y = 0, high_x = ~0u, high_y = ~0u;
};

// Where the heights of triangles' corners are known, if not among the samples: every 2^log2 of the lattice.
struct CornerHeights {
  Heights heights;
  uint32_t log2 = 0;
  int32_t at(proto::NodeId v) const { return heights.clamped(v.x() >> log2, v.y() >> log2); }
};

class PlanarError {
 public:
  PlanarError(const proto::GridTopology& grid, const proto::Frame& frame, const Heights& heights)
      : PlanarError(grid, frame, heights, CornerHeights{heights}) {}
  PlanarError(const proto::GridTopology& grid, const proto::Frame& frame, const Heights& heights,
              const CornerHeights& corners);
  // In a window: the largest over several windows is that over all of them. Triangles that only touch it are left out.
  double metres(proto::NodeId n, const ErrorWindow& window = {}) const;
  double inMetres(double quanta) const;

 private:
  const proto::GridTopology& grid_;
  Heights heights_;
  CornerHeights corners_;
  double height_quantum_m_;
};

class GeographicError {
 public:
  // `tables` are those of the frame for all of the grid; the caller keeps them.
  GeographicError(const proto::GridTopology& grid, const proto::Frame& frame, const Heights& heights,
                  const proto::GeographicTables& tables)
      : GeographicError(grid, frame, heights, CornerHeights{heights}, tables) {}
  GeographicError(const proto::GridTopology& grid, const proto::Frame& frame, const Heights& heights,
                  const CornerHeights& corners, const proto::GeographicTables& tables);
  double metres(proto::NodeId n, const ErrorWindow& window = {}) const;

 private:
  glm::dvec3 corner(proto::NodeId v) const;

  const proto::GridTopology& grid_;
  Heights heights_;
  CornerHeights corners_;
  double height_quantum_m_;
  double polar_;  // (1 - e^2): shortens the normal along the axis
  const proto::GeographicTables& tables_;
};

}  // namespace foreland::terrain
