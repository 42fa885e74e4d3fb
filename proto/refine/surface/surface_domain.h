// What both ends know of a surface before any of its nodes: how its nodes are named, and by which tolerances they are
// tested. Immutable; any thread; the topology must outlive it.
#pragma once

#include "proto/refine/surface/surface_metric.h"
#include "proto/section/bounds.h"
#include "proto/topology/mesh_topology.h"

namespace foreland::proto {

struct SurfaceDomain {
  using Topology = MeshTopology;
  using Metric = SurfaceMetric;

  const MeshTopology* mesh;
  double quantum_m;             // what positions are multiples of
  double interior_per_tau = 7;  // tolerance where there is no silhouette, as a multiple of the view's (S, figure 8)
  double nearest_m = 0.1;       // metres of depth below which nothing is guaranteed
  bool is_closed = true;        // back faces are not visible
  ErrorShape shape = ErrorShape::kSpheroid;

  const MeshTopology& topology() const { return *mesh; }
  // `view` in the object's frame.
  SurfaceMetric metric(const View& view) const {
    return SurfaceMetric(view, {interior_per_tau * view.tau_px, nearest_m, is_closed, shape});
  }
  static MotionBound motionBound(const View& from, const View& to) { return SurfaceMetric::motionBoundTo(from, to); }
};

}  // namespace foreland::proto
