#include "server/section/budget.h"

#include <algorithm>
#include <cmath>

namespace foreland::server {

namespace {

constexpr double kMiddle = 0.9;         // of the budget: where triangles are steered to
constexpr double kTrianglePower = 1.2;  // triangles fall as tau^-1.2
constexpr double kShare = 0.5;          // of the distance, per keyframe
constexpr double kLargestStep = 0.08;   // of log tau, per keyframe
constexpr double kBytesRise = 0.06, kBytesLow = 0.7;
constexpr double kBytesFall = 0.01;  // at kBytesLow; at less the more, as it costs less
constexpr double kMemory_s = 2;      // of the byte rate

}  // namespace

double ToleranceControl::next(double wanted_px, const Budget& budget) {
  if (tau_px_ == 0) tau_px_ = wanted_px;
  double by_triangles = -kLargestStep, by_bytes = -kLargestStep;  // without a limit tau falls back to what is wanted
  if (budget.triangles > 0 && triangles_ > 0)
    by_triangles = kShare * std::log(triangles_ / (kMiddle * budget.triangles)) / kTrianglePower;
  if (budget.bytes_per_second > 0) {
    const double load = bytes_per_s_ / budget.bytes_per_second;
    by_bytes = load > 1           ? std::min(kBytesRise, std::log(load))
               : load > kBytesLow ? 0
                                  : -kBytesFall * kBytesLow / std::max(load, kBytesFall);
  }
  const double step = std::clamp(std::max(by_triangles, by_bytes), -kLargestStep, kLargestStep);
  tau_px_ = std::max(wanted_px, tau_px_ * std::exp(step));
  return tau_px_;
}

void ToleranceControl::observe(double triangles, double bytes, double interval_s) {
  triangles_ = triangles;
  const double share = 1 - std::exp(-interval_s / kMemory_s);
  bytes_per_s_ += share * (bytes / interval_s - bytes_per_s_);
}

}  // namespace foreland::server
