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

class PlanarError {
 public:
  PlanarError(const proto::GridTopology& grid, const proto::Frame& frame, const Heights& heights);
  double metres(proto::NodeId n) const;
  double inMetres(double quanta) const;

 private:
  const proto::GridTopology& grid_;
  Heights heights_;
  double height_quantum_m_;
};

class GeographicError {
 public:
  // `tables` are those of the frame for all of the grid; the caller keeps them.
  GeographicError(const proto::GridTopology& grid, const proto::Frame& frame, const Heights& heights,
                  const proto::GeographicTables& tables);
  double metres(proto::NodeId n) const;

 private:
  glm::dvec3 corner(proto::NodeId v) const;

  const proto::GridTopology& grid_;
  Heights heights_;
  double height_quantum_m_;
  double polar_;  // (1 - e^2): shortens the normal along the axis
  const proto::GeographicTables& tables_;
};

}  // namespace foreland::terrain
