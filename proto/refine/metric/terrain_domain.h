// What both ends know of a terrain from the start, before any node: how its nodes are named, where they lie, how large
// their spheres are. The refinement test (metric.h) on it is the same arithmetic on both ends, to the last bit.
// Immutable; any thread.
#pragma once

#include <limits>

#include "proto/refine/metric/motion_margin.h"
#include "proto/section/bounds.h"
#include "proto/space/frame_grid.h"
#include "proto/topology/grid.h"

namespace foreland::proto {

// What is taken to bound an error's direction. The spheroid of S, 3.3.3, is degenerate for terrain: its errors are
// purely vertical, which seen from above projects to almost nothing. On a curved frame they are not quite, so there a
// sphere is taken.
enum class ErrorBound : uint8_t { kSpheroid, kSphere };

struct TerrainDomain {
  using Topology = GridTopology;
  using Metric = proto::Metric;

  GridTopology grid;
  FrameGrid frame;
  SphereLevels spheres;
  bool has_vertical_errors;
  double ceiling_m;  // that no ground lies above; of a globe's horizon

  TerrainDomain(const GridTopology& topology, const Frame& f, ErrorBound bound = ErrorBound::kSpheroid,
                double ceiling = std::numeric_limits<double>::infinity())
      : grid(topology),
        frame(f, topology.maxX(), topology.maxY()),
        spheres(topology, f),
        has_vertical_errors(f.kind == FrameKind::kPlanar && bound == ErrorBound::kSpheroid),
        ceiling_m(ceiling) {}

  const GridTopology& topology() const { return grid; }
  Metric metric(const View& view) const {
    const Frame& f = frame.transform().frame();
    return f.kind == FrameKind::kGlobe ? Metric(view, f, ceiling_m) : Metric(view, has_vertical_errors);
  }
  MotionBound motionBound(const View& from, const View& to) const {
    return MotionMargin(metric(from)).motionBoundTo(from, to);
  }
  float radius(int level, QuantisedRadius c) const { return spheres.radius(level, c); }
  bool isPlanar() const { return frame.transform().frame().kind == FrameKind::kPlanar; }
};

}  // namespace foreland::proto
