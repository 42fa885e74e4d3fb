// The exact error of leaving one node out (DESIGN section 3): the largest distance, over the data samples of the node's
// support, between the true surface and the surface without the node, at the same parameter. Not saturated; bounds.h
// does that.
//
//   planar      both points lie above the same place, so the distance is vertical; exact
//   geographic  in space, curvature included; overstated by at most 1e-7 m, which covers rounding; less than
//               2e-8 m counts as nothing
//
// Immutable after construction; any thread. Cost: O(samples of the support), four samples at a time.
#pragma once

#include <vector>

#include "proto/space/frame.h"
#include "proto/topology/grid.h"
#include "terrain/bounds/heights.h"

namespace foreland::terrain {

class PlanarError {
 public:
  PlanarError(const proto::GridTopology& grid, const proto::Frame& frame, const Heights& heights);
  double metres(proto::NodeId n) const;
  double inMetres(double steps) const;

 private:
  const proto::GridTopology& grid_;
  Heights heights_;
  double step_m_;
};

class GeographicError {
 public:
  GeographicError(const proto::GridTopology& grid, const proto::Frame& frame, const Heights& heights);
  double metres(proto::NodeId n) const;

 private:
  glm::dvec3 corner(proto::NodeId v) const;

  const proto::GridTopology& grid_;
  Heights heights_;
  double step_m_;
  double polar_;                                  // (1 - e^2): shortens the normal along the axis
  std::vector<double> sin_lon_, cos_lon_;         // by column, grid wide
  std::vector<proto::FrameTransform::Row> rows_;  // by row
};

}  // namespace foreland::terrain
