// Times the steps of real sessions, from which the prices of their work follow (compute_cost.h). The processor time of
// the calling thread is taken; run it on a calm machine.
#pragma once

#include <memory>
#include <vector>

#include "server/session/world.h"
#include "sim/compute_cost.h"

namespace foreland::lab {

// Flies `seconds` of each tour over the scene, predicted and with the path known, at two tolerances; if the world has
// what occlusion needs, with that, too.
std::vector<sim::TimedWork> timeSteps(std::shared_ptr<const server::World> world, double seconds);

struct Calibration {
  sim::ComputePrices prices;
  uint64_t steps = 0;
  double total_s = 0;       // of all steps
  double total_error = 0;   // share by which the prices' sum is off
  double median_error = 0;  // of one step

  template <class Visit>
  void fields(const Visit& visit) const {
    prices.fields(visit);
    visit("steps", steps);
    visit("total_s", total_s);
    visit("total_error", total_error);
    visit("median_error", median_error);
  }
};
Calibration calibrate(const std::vector<sim::TimedWork>& steps);

}  // namespace foreland::lab
