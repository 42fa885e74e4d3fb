#include "server/section/budget.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace foreland::server {

namespace {

constexpr double kMiddle = 0.9;         // where triangles are steered to, of the budget
constexpr double kTrianglePower = 1.2;  // triangles fall as tau^-1.2
constexpr double kShare = 0.5;          // of the distance to the middle that a keyframe covers
constexpr double kLargestStep = 0.08;   // of log tau, for a keyframe
constexpr double kBytesRise = 0.06;     // of log tau at most, while too many bytes are sent
constexpr double kBytesLow = 0.7;       // below this share of the budget tau falls again
constexpr double kBytesFall = 0.01;     // of log tau at kBytesLow; more at a lower rate, where it costs less
constexpr double kMemory_s = 2;         // over which the byte rate is smoothed

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

double raiseUntil(double tau_px, double factor, const std::function<bool(double)>& fits) {
  if (fits(tau_px)) return tau_px;
  std::array<float, kMostRises + 1> tau;
  tau[0] = static_cast<float>(tau_px);
  for (size_t i = 1; i < tau.size(); ++i)
    tau[i] = std::min(static_cast<float>(double{tau[i - 1]} * factor), kMostTolerance_px);
  // Doubles the number of rises until it fits, then bisects.
  size_t too_few = 0, enough = 1;
  while (enough < kMostRises && !fits(tau[enough]))
    too_few = std::exchange(enough, std::min<size_t>(2 * enough, kMostRises));
  while (enough - too_few > 1) {
    const size_t middle = (too_few + enough) / 2;
    (fits(tau[middle]) ? enough : too_few) = middle;
  }
  return tau[enough];
}

}  // namespace foreland::server
