// What both ends know of a surface from the start, before any node: how its nodes are named, and by which tolerances
// they are tested. Immutable; any thread; the topology must outlive it.
#pragma once

#include "proto/refine/surface_metric.h"
#include "proto/section/bounds.h"
#include "proto/topology/mesh_topology.h"

namespace foreland::proto {

struct SurfaceDomain {
  using Topology = MeshTopology;
  using Metric = SurfaceMetric;

  const MeshTopology* mesh;
  double step_m;                // of positions
  double interior_per_tau = 7;  // tolerance where there is no silhouette, as a multiple of the view's (S, figure 8)
  double nearest_m = 0.1;       // nothing nearer is promised anything: metres of depth
  bool is_closed = true;        // back faces are not seen
  ErrorShape shape = ErrorShape::kSpheroid;

  const MeshTopology& topology() const { return *mesh; }
  // `view` in the object's frame.
  SurfaceMetric metric(const View& view) const {
    return SurfaceMetric(view, {interior_per_tau * view.tau_px, nearest_m, is_closed, shape});
  }
  // Spheres stand in the records.
  float radius(int, QuantisedRadius) const { return 0; }
};

}  // namespace foreland::proto
