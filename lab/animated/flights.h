// A flight through a scene that changes in time, once with its clock running and once with it stopped, in virtual time
// (sim): what the ground's motion costs on the wire, and whether frames keep the tolerance. The same figures on
// any machine. One caller.
#pragma once

#include <memory>
#include <string>

#include "base/result.h"
#include "lab/sections/flight_views.h"
#include "server/session/world.h"

namespace foreland::lab {

struct AnimatedFlight {
  uint64_t bytes_down = 0, keyframes = 0, late_keyframes = 0;
  double max_error_px_frames = 0;
  uint64_t frames_judged = 0, frames_over_tau = 0;

  template <class Visit>
  void fields(const Visit& visit) const {
    visit("bytes_down", bytes_down);
    visit("keyframes", keyframes);
    visit("late_keyframes", late_keyframes);
    visit("max_error_px_frames", max_error_px_frames);
    visit("frames_judged", frames_judged);
    visit("frames_over_tau", frames_over_tau);
  }
};

// Along `path`, predicted from the known path; `rate` scene seconds a second from the first epoch on. One frame in
// `judge_every` is judged.
Result<AnimatedFlight> flyAnimated(const std::shared_ptr<const server::World>& world,
                                   const std::shared_ptr<const terrain::Scene>& scene, const proto::Path& path,
                                   const FlightOptions& options, double rate, uint32_t judge_every);

}  // namespace foreland::lab
