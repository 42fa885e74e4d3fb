// What a flight of `foreland bench latency` comes to: errors and motion of the judged frames, delay, triangles and
// regions of all that were shown. Pure; any thread.
#pragma once

#include <string>

#include "lab/latency/fly_cell.h"

namespace foreland::lab {

// Of one error term over the judged frames. `max` and `p99` are of the largest error in a frame; `rms` is the root of
// the mean over frames of the mean square in a frame.
struct TermFigures {
  double max_px = 0, p99_px = 0, mean_px = 0, rms_px = 0;
  double max_m = 0, p99_m = 0, mean_m = 0, rms_m = 0;

  template <class Visit>
  void fields(const Visit& visit) const {
    visit("max_px", max_px);
    visit("p99_px", p99_px);
    visit("mean_px", mean_px);
    visit("rms_px", rms_px);
    visit("max_m", max_m);
    visit("p99_m", p99_m);
    visit("mean_m", mean_m);
    visit("rms_m", rms_m);
  }
};

struct CellFigures {
  LatencyCell cell;
  std::array<TermFigures, kTerms> terms;
  uint64_t frames = 0, judged = 0, outside = 0, bound_violations = 0, over_tau = 0, over_stated = 0;
  double stated_mean_px = 0, stated_max_px = 0;
  double delay_mean_ms = 0, delay_max_ms = 0;
  double lod_motion_p99_px = 0, lod_motion_max_px = 0;
  double triangles = 0;  // mean
  uint64_t keyframes = 0, late = 0, bytes_down = 0, bytes_up = 0;
  double down_kbit_s = 0, lateness_p99_ms = 0, lateness_max_ms = 0, compute_mean_ms = 0, compute_p99_ms = 0;

  // Every figure with its name, in the order of the columns of results.csv.
  template <class Visit>
  void fields(const Visit& visit) const {
    cell.fields(visit);
    for (size_t i = 0; i < kTerms; ++i)
      terms[i].fields([&](const char* norm, double value) {
        visit((std::string(name(static_cast<Term>(i))) + "_" + norm).c_str(), value);
      });
    visit("delay_mean_ms", delay_mean_ms);
    visit("delay_max_ms", delay_max_ms);
    visit("lod_motion_p99_px", lod_motion_p99_px);
    visit("lod_motion_max_px", lod_motion_max_px);
    visit("triangles", triangles);
    visit("frames", frames);
    visit("frames_judged", judged);
    visit("frames_outside", outside);
    visit("frames_over_tau", over_tau);
    visit("frames_over_stated", over_stated);
    visit("stated_mean_px", stated_mean_px);
    visit("stated_max_px", stated_max_px);
    visit("bound_violations", bound_violations);
    visit("keyframes", keyframes);
    visit("late_keyframes", late);
    visit("lateness_p99_ms", lateness_p99_ms);
    visit("lateness_max_ms", lateness_max_ms);
    visit("compute_mean_ms", compute_mean_ms);
    visit("compute_p99_ms", compute_p99_ms);
    visit("bytes_down", bytes_down);
    visit("bytes_up", bytes_up);
    visit("down_kbit_s", down_kbit_s);
  }
};

CellFigures figuresOf(const CellFlight& flight, double seconds);

}  // namespace foreland::lab
