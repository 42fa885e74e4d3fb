#include "server/section/budget.h"

#include <algorithm>
#include <cmath>

#include "base/smoothing.h"

namespace foreland::server {

namespace {

constexpr double kMiddle = 0.9;           // where triangles are steered to, of the budget
constexpr double kTrianglePower = 1.2;    // triangles fall as tau^-1.2
constexpr double kShare = 0.5;            // of the distance to the middle that a keyframe covers
constexpr double kLargestStep = 0.08;     // of log tau, for a keyframe
constexpr double kUsual_s = 0.2;          // between keyframes; after longer intervals it falls by more at once
constexpr double kMaxLonger = 5;          // by this factor at most
constexpr double kBytesRise = 0.06;       // of log tau at most, while too many bytes are sent
constexpr double kBytesLow = 0.7;         // below this share of the budget tau falls again
constexpr double kBytesFall = 0.01;       // of log tau at kBytesLow; more at a lower rate, where it costs less
constexpr double kProcessorsFall = 0.02;  // of log tau, once processors are free again
constexpr double kMemory_s = 2;           // over which the byte rate is smoothed
constexpr double kForcedFall = 0.35;      // of log tau at most, down to where it was before it was forced up

// Of toleranceThatFits().
constexpr double kAimedLoad = 0.9;  // by the power law
constexpr double kCoarser = 4;      // by this factor, and its powers, while nothing was measured whole

}  // namespace

double ToleranceControl::next(double wanted_px, const Budget& budget) {
  if (tau_px_ == 0) tau_px_ = wanted_px;
  const double min_px = std::max(wanted_px, unforced_px_);
  const double largest_fall = kLargestStep * std::clamp(interval_s_ / kUsual_s, 1.0, kMaxLonger);
  const double fall = unforced_px_ > 0
                          ? std::clamp(std::log(tau_px_ / min_px), largest_fall, std::max(largest_fall, kForcedFall))
                          : largest_fall;
  double by_triangles = -fall, by_bytes = -fall;  // without a limit tau falls back to what is wanted
  if (budget.triangles > 0 && triangles_ > 0)
    by_triangles = kShare * std::log(triangles_ / (kMiddle * budget.triangles)) / kTrianglePower;
  if (budget.bytes_per_second > 0) {
    const double load = bytes_per_s_ / budget.bytes_per_second;
    by_bytes = load > 1           ? std::min(kBytesRise, std::log(load))
               : load > kBytesLow ? 0
                                  : -kBytesFall * kBytesLow / std::max(load, kBytesFall);
  }
  was_scarce_ = tau_px_ > wanted_px && (was_scarce_ || budget.processors == Processors::kScarce);
  double by_processors = was_scarce_ ? -kProcessorsFall : -fall;
  if (budget.processors == Processors::kScarce) by_processors = kLargestStep;
  if (budget.processors == Processors::kTaken && was_scarce_) by_processors = 0;
  was_scarce_ = was_scarce_ || budget.processors == Processors::kScarce;
  const double step = std::clamp(std::max({by_triangles, by_bytes, by_processors}), -fall, kLargestStep);
  tau_px_ = std::max(wanted_px, tau_px_ * std::exp(step));
  if (tau_px_ <= min_px) unforced_px_ = 0;
  return tau_px_;
}

void ToleranceControl::observe(double triangles, double bytes, double interval_s) {
  triangles_ = triangles;
  interval_s_ = interval_s;
  const double share = weightOfNew(interval_s, kMemory_s);
  bytes_per_s_ += share * (bytes / interval_s - bytes_per_s_);
}

void ToleranceControl::force(double tau_px) {
  constexpr double kRounding = 1e-6;
  if (tau_px > tau_px_ * (1 + kRounding)) unforced_px_ = unforced_px_ > 0 ? std::min(unforced_px_, tau_px_) : tau_px_;
  tau_px_ = tau_px;
}

void ToleranceControl::restart() {
  tau_px_ = unforced_px_ = 0;
  triangles_ = 0;
}

namespace {

double nextTry(double too_fine_px, double enough_px, double load, double tried_px, int tries) {
  // By the power law, a little above what it says, as long as it helps to narrow the interval.
  double next_px = std::isfinite(load) ? tried_px * std::pow(load / kAimedLoad, 1 / kTrianglePower)
                                       : tried_px * kCoarser * std::pow(kCoarser, tries);
  if (enough_px == 0) return std::max(next_px, 1.05 * too_fine_px);
  const double middle_px = std::sqrt(too_fine_px * enough_px);
  return next_px > too_fine_px && next_px < enough_px ? next_px : middle_px;
}

}  // namespace

double toleranceThatFits(double tau_px, double guess_px, const std::function<double(double)>& load) {
  double too_fine_px = tau_px, enough_px = 0, tried_px = tau_px;
  double loaded = load(tau_px);
  if (loaded <= 1) return tau_px;
  for (int tries = 0; tries + 1 < kMaxTries; ++tries) {
    const bool is_guess = tries == 0 && guess_px > tau_px;
    const double next_px = is_guess ? guess_px : nextTry(too_fine_px, enough_px, loaded, tried_px, tries);
    tried_px = std::min(static_cast<float>(next_px), kMaxTolerance_px);
    loaded = load(tried_px);
    (loaded <= 1 ? enough_px : too_fine_px) = tried_px;
    const bool is_tight = enough_px > 0 && enough_px <= 1.1 * too_fine_px;
    if (is_tight || tried_px >= kMaxTolerance_px || (loaded <= 1 && loaded >= kMinLoad)) break;
  }
  return enough_px > 0 ? enough_px : kMaxTolerance_px;
}

}  // namespace foreland::server
