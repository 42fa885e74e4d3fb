// Measures a recorded flight against the truth: replays it frame by frame (client/fly/player.h) and puts frames before
// the oracle. Since the replay shows exactly what the flight showed, measuring costs the flight nothing and may take
// its time.
//
// What is measured, and where each number comes from (THEORY section 4):
// Errors at keyframes and in frames are those of all that is drawn, terrain and objects (scene_oracle.h); the terms
// below them are the terrain's.
//
//   error at keyframes  what is drawn at each keyframe's time (weight 1: its section, but for geomorphs) against the
//                       truth, seen from the pose it was computed for
//   error in frames     what is drawn against the truth, seen as the frame shows it
//   interpolation       |S_view(s) - S_inter(s)|, s the time shown. `delay`, `current`, geomorphs: S_inter is what is drawn.
//                       `predict`: between the sections for the true poses at the two keyframes' times, so that extrapolation
//                       stays apart
//   view                |S_view(t) - S_view(t_d)|; `current` only, zero otherwise
//   extrapolation       |S_view(t_i) - S_extra(t_i)|, once per keyframe, seen from the true pose at t_i; `predict` only
//   delay               t - t_d
//   lod motion          what the weights alone move on the screen from the frame before to this one, both seen from this one's
//                       pose, for a 60th of a second (lod_motion.h); frames whose mesh is new are left out. The root mean
//                       square is over all vertices seen, the 99th percentile over those that move
// S_view(t) is refined for the pose at t alone. Where a keyframe was refined for a region around its pose, its
// counterpart for the true pose gets the same region, for that is the error guarantee's doing, not extrapolation's.
// Norms of the terms are taken over the samples that the frame sees. `max` is the largest over all frames of the
// largest in a frame, `mean` the mean over frames of the largest in a frame, `rms` the root of the mean over frames of
// the mean square in a frame.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "client/fly/player.h"
#include "oracle/frame_sampling.h"
#include "oracle/scene_oracle.h"
#include "oracle/section_at.h"

namespace foreland::oracle {

struct TermNorms {
  double max_px = 0, mean_px = 0, rms_px = 0;
  double max_m = 0, mean_m = 0, rms_m = 0;
  uint64_t count = 0;  // frames or keyframes measured

  template <class Visit>
  void fields(const Visit& visit) const {
    visit("max_px", max_px);
    visit("mean_px", mean_px);
    visit("rms_px", rms_px);
    visit("max_m", max_m);
    visit("mean_m", mean_m);
    visit("rms_m", rms_m);
  }
  void add(const Deviation& d);
  void finish();
};

struct FlightTruth {
  TermNorms keyframes, frames;                   // against the truth
  TermNorms interpolation, view, extrapolation;  // of THEORY section 4; empty without a SectionAt
  TermNorms lod_motion;                          // pixels only
  double lod_motion_p99_px = 0;
  uint32_t frame_every = 1;  // the stride that was taken: at least the one asked for, without a factor in common with
                             // the frames per keyframe at 60 a second
  uint32_t keyframe_every = 1;                                       // likewise, of keyframes
  JudgedWeights weights_judged;                                      // of frames
  double object_silhouette_error_px = 0;                             // largest, keyframes and frames
  double object_interior_error_px = 0, object_interior_per_tau = 1;  // the same; its tolerance, as a multiple of tau
  uint64_t object_vertices_judged = 0;
  // Of a globe's files, keyframes and frames: the largest distance of a sample from what is drawn; what of it is more
  // than the file's residual looks like, which counts among the errors above; and how often one was looked at.
  double source_error_px = 0, source_excess_px = 0;
  uint64_t source_samples_judged = 0;
  double delay_max_ms = 0, delay_mean_ms = 0;
  uint64_t keyframes_over_tau = 0, frames_over_tau = 0;  // of those measured, over the tolerance that each states
  uint64_t outside_measured = 0;                         // of those measured, frames that no region covers
  uint64_t outside_over_tau = 0;                         // of these, those over tau
  double outside_p99_px = 0, outside_max_px = 0;         // their errors
  uint64_t uncovered_samples = 0;  // seen, but drawn by no triangle: samples of the terrain, vertices of objects
  uint64_t cracks = 0;
  std::string first_crack;
  bool has_terms = false;  // they were asked for
  bool is_whole = true;    // false if on_progress ended it: then all this is of the beginning of the flight

  template <class Visit>
  void fields(const Visit& visit) const {
    visit("max_error_px_keyframes", keyframes.max_px);
    visit("mean_error_px_keyframes", keyframes.mean_px);
    visit("max_error_px_frames", frames.max_px);
    visit("mean_error_px_frames", frames.mean_px);
    visit("rms_error_px_frames", frames.rms_px);
    visit("measured_keyframes", keyframes.count);
    visit("measured_frames", frames.count);
    visit("measure_every", frame_every);
    visit("measure_keyframes_every", keyframe_every);
    visit("weights_judged", weights_judged);
    visit("keyframes_over_tau", keyframes_over_tau);
    visit("frames_over_tau", frames_over_tau);
    visit("measured_frames_outside", outside_measured);
    visit("outside_frames_over_tau", outside_over_tau);
    visit("outside_error_p99_px", outside_p99_px);
    visit("outside_error_max_px", outside_max_px);
    visit("cracks", cracks);
    if (!first_crack.empty()) visit("first_crack", first_crack);
    visit("uncovered_samples", uncovered_samples);
    visit("object_vertices_judged", object_vertices_judged);
    visit("object_silhouette_error_px", object_silhouette_error_px);
    visit("object_interior_error_px", object_interior_error_px);
    visit("object_interior_per_tau", object_interior_per_tau);
    if (source_samples_judged > 0) {
      visit("source_error_px", source_error_px);
      visit("source_excess_px", source_excess_px);
      visit("source_samples_judged", source_samples_judged);
    }
    if (has_terms) {
      term("interpolation_error_", interpolation, visit);
      term("view_error_", view, visit);
      term("extrapolation_error_", extrapolation, visit);
    }
    visit("lod_motion_max_px", lod_motion.max_px);
    visit("lod_motion_p99_px", lod_motion_p99_px);
    visit("lod_motion_mean_px", lod_motion.mean_px);
    visit("lod_motion_rms_px", lod_motion.rms_px);
    visit("delay_max_ms", delay_max_ms);
    visit("delay_mean_ms", delay_mean_ms);
  }

 private:
  template <class Visit>
  static void term(const std::string& name, const TermNorms& norms, const Visit& visit) {
    norms.fields([&](const char* norm, double value) { visit((name + norm).c_str(), value); });
  }
};

struct FlightTruthOptions {
  uint32_t frame_every = 7;  // one frame in so many is measured, or more (FlightTruth)
  // If not 0: not more frames are measured, nor more keyframes, evenly over the flight; otherwise all keyframes.
  uint32_t max_frames = 0;
  // Makes what computes sections for one thread; called on the calling thread. Absent: no error terms.
  std::function<SectionAt()> sections;
  uint32_t terms_every = 1;  // terms are measured for one in so many measured frames, and keyframes; 0: for none
  unsigned threads = 1;      // that judge; 0 for one per processor. The result does not depend on it
  // Told what share is done, after each piece of work, on the calling thread; ends the measurement by returning false.
  std::function<bool(double)> on_progress{};
};

// Memory: for each thread two meshes that wait or are judged, an oracle's scratch (Oracle::twin) and what `sections`
// needs; with meshes of 400,000 triangles MEASURED MB a thread.
FlightTruth measureFlight(const client::FlightLog& log, SceneOracle& oracle, const FlightTruthOptions& options);

}  // namespace foreland::oracle
