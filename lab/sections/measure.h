// What sections cost along a flight. Timings compare refinement from scratch
// with adaptation in turn, view by view, in one run; medians are reported, for processors are shared. One thread unless
// it says otherwise.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "base/result.h"
#include "lab/sections/flight_views.h"
#include "server/section/hierarchy.h"

namespace foreland::lab {

struct SectionCosts {
  double nodes = 0, triangles = 0, changed_fraction = 0;  // means
  double refine_mtri_per_s = 0;         // median over the keyframes of a keyframe's triangles over its time
  double refine_ms = 0, adapt_ms = 0;   // medians
  double adapt_us_per_change = 0;       // all the time over all changes
  double ratio = 0;                     // median of refine_ms over median of adapt_ms
  double keyframes_per_s_per_core = 0;  // of adaptation
  uint64_t allocations = 0;             // in the second half of the flight

  template <class Visit>
  void fields(const Visit& visit) const {
    visit("nodes", nodes);
    visit("triangles", triangles);
    visit("changed_fraction", changed_fraction);
    visit("refine_mtri_per_s", refine_mtri_per_s);
    visit("refine_ms", refine_ms);
    visit("adapt_ms", adapt_ms);
    visit("adapt_us_per_change", adapt_us_per_change);
    visit("ratio", ratio);
    visit("keyframes_per_s_per_core", keyframes_per_s_per_core);
    visit("allocations_in_steady_state", allocations);
  }
};
SectionCosts measureCosts(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views);

// What the server keeps of one viewer between keyframes, objects included, at its largest: the adapters, the coders'
// models, what it knows that the viewer knows. All zero under a sanitizer.
struct SessionMemory {
  double bytes = 0, bytes_per_node = 0;

  template <class Visit>
  void fields(const Visit& visit) const {
    visit("session_bytes", bytes);
    visit("bytes_per_node", bytes_per_node);
  }
};
SessionMemory measureMemory(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views);

// Mean triangles over the views.
double meanTriangles(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views);

// The tolerance (px) with which the views have so many triangles in the mean, to 1 %, so that scenes can be compared at
// equal work. By bisection over a sample of the views. An Error if no tolerance from 0.01 to 1000 px does.
Result<double> tauForTriangles(const server::Hierarchy& hierarchy, std::vector<proto::View> views, double triangles);

// Of the terrain alone: what is gained and paid, as shares of triangles; and how well two threads do.
struct SectionComparisons {
  double two_threads_over_one = 0;
  double guarantee_triangle_overhead = 0;  // of keeping tau in every frame, over keeping it at keyframes alone
  double spheroid_triangle_saving = 0;     // of knowing that errors are vertical

  template <class Visit>
  void fields(const Visit& visit) const {
    visit("two_threads_over_one", two_threads_over_one);
    visit("guarantee_triangle_overhead", guarantee_triangle_overhead);
    visit("spheroid_triangle_saving", spheroid_triangle_saving);
  }
};
SectionComparisons measureComparisons(const server::Hierarchy& hierarchy, const proto::Path& path,
                                      const FlightOptions& options);

}  // namespace foreland::lab
