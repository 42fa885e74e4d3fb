// What sections cost along a tour, and whether they keep their word. Timings compare refinement from scratch with
// adaptation in turn, view by view, in one run; medians are reported, for these machines are noisy. One thread unless
// it says otherwise.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "base/result.h"
#include "bench/sections/flight_views.h"
#include "server/section/hierarchy.h"

namespace foreland::bench {

struct SectionCosts {
  double nodes = 0, triangles = 0, changed_fraction = 0;  // means
  double refine_ms = 0, adapt_ms = 0;                     // medians
  double refine_mtri_per_s = 0;                           // all triangles over all the time
  double adapt_us_per_change = 0;                         // all the time over all changes
  double ratio = 0;                                       // median of refine_ms over median of adapt_ms
  double keyframes_per_s_per_core = 0;                    // of adaptation
  double bytes_per_node = 0;                              // of a session's state at its largest
  uint64_t allocations = 0;                               // in the second half of the flight
};
SectionCosts measureCosts(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views);

// Mean triangles over the views.
double meanTriangles(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views);

// The tolerance (px) with which the views have so many triangles in the mean, to 1 %, so that scenes can be compared at
// equal work. By bisection over a sample of the views. An Error if no tolerance from 0.01 to 1000 px does.
Result<double> tauForTriangles(const server::Hierarchy& hierarchy, std::vector<proto::View> views, double triangles);

struct SectionErrors {
  double max_error_px_keyframes = 0, max_error_px_frames = 0;
  uint64_t frames = 0, frames_over_tau = 0;
  double lod_motion_px_per_frame = 0;      // largest
  double lod_motion_px_per_frame_p99 = 0;  // of all visible vertices of all keyframe intervals
  uint64_t cracks = 0;
};
// Replays the flight through encoder, decoder and mesh as a client sees it, with `frames_per_keyframe` shown frames, of
// which every `measure_every`-th is put before the oracle.
SectionErrors measureErrors(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views,
                            const proto::Path& path, const FlightOptions& options, uint32_t frames_per_keyframe,
                            uint32_t measure_every);

// Work done per second by `threads` threads, each adapting sessions of its own along the views.
double keyframesPerSecond(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views, unsigned threads);

}  // namespace foreland::bench
