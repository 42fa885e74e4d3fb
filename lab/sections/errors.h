// Whether every frame of a flight keeps its tolerance, as the oracle finds it. One thread.
#pragma once

#include <vector>

#include "lab/sections/flight_views.h"
#include "oracle/frame_sampling.h"
#include "server/section/hierarchy.h"

namespace foreland::lab {

struct SectionErrors {
  double max_error_px_keyframes = 0, max_error_px_frames = 0;  // of SceneDeviation: terrain and objects
  uint64_t frames = 0, frames_over_tau = 0, uncovered_samples = 0;
  uint32_t measure_every = 1;
  oracle::JudgedWeights weights_judged;
  uint64_t object_vertices_judged = 0;
  double object_silhouette_error_px = 0, object_interior_error_px = 0, object_interior_per_tau = 1;
  double lod_motion_px_per_frame = 0;      // largest
  double lod_motion_px_per_frame_p99 = 0;  // of all visible vertices that move, in all keyframe intervals
  uint64_t cracks = 0;

  template <class Visit>
  void fields(const Visit& visit) const {
    visit("max_error_px_keyframes", max_error_px_keyframes);
    visit("max_error_px_frames", max_error_px_frames);
    visit("measured_frames", frames);
    visit("measure_every", measure_every);
    visit("weights_judged", weights_judged);
    visit("frames_over_tau", frames_over_tau);
    visit("uncovered_samples", uncovered_samples);
    visit("object_vertices_judged", object_vertices_judged);
    visit("object_silhouette_error_px", object_silhouette_error_px);
    visit("object_interior_error_px", object_interior_error_px);
    visit("object_interior_per_tau", object_interior_per_tau);
    visit("lod_motion_px_per_frame", lod_motion_px_per_frame);
    visit("lod_motion_px_per_frame_p99", lod_motion_px_per_frame_p99);
    visit("cracks", cracks);
  }
};

struct FrameSampling {
  uint32_t frames_per_keyframe = 12;
  uint32_t measure_every = 7;  // a larger stride is taken if it shares a factor with the frames per keyframe
};

// Replays the flight through encoder, decoder and mesh as a client sees it, and puts the frames that are sampled and
// all keyframes before the oracle.
SectionErrors measureErrors(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views,
                            const proto::Path& path, const FlightOptions& options, const FrameSampling& sampling);

}  // namespace foreland::lab
