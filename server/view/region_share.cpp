#include "server/view/region_share.h"

#include <cmath>

namespace foreland::server {

Region RegionShare::of(const RegionParts& parts) const {
  const double of_error = share_ > kLeast ? share_ : 0;
  const Region without = parts.withoutErrors();
  return {without.radius_m + of_error * parts.error.radius_m, without.angle_rad + of_error * parts.error.angle_rad};
}

double RegionShare::shareOf(const RegionParts& parts) const {
  const Region left = of(parts), whole = RegionShare().of(parts);
  const auto share = [](double part, double all) { return all > 0 ? part / all : 1.0; };
  return std::min(share(left.radius_m, whole.radius_m), share(left.angle_rad, whole.angle_rad));
}

// With what is always allowed for, so that errors below it do not count as growth.
Region RegionShare::errorsOf(const RegionParts& parts) const {
  return {share_ * parts.error.radius_m + parts.rest.radius_m, share_ * parts.error.angle_rad + parts.rest.angle_rad};
}

double RegionShare::expectedExcess(const RegionParts& parts) const {
  constexpr double kMin = 0.01;  // sections with small errors differ by chance
  constexpr double kRadius_m = 1e-3, kAngle_rad = 1e-5;
  const Region errors = errorsOf(parts);
  const double growth = std::max(errors.radius_m / std::max(observed_.radius_m, kRadius_m),
                                 errors.angle_rad / std::max(observed_.angle_rad, kAngle_rad));
  return growth * std::max(excess_, kMin);
}

bool RegionShare::isForeseen(double excess) const {
  constexpr double kSmall = 0.9 * (kMax - 1), kAlike = 1.1;
  if (excess <= kSmall && excess_ <= 2 * kSmall) return true;
  return excess <= kAim - 1 && excess <= kAlike * excess_ && excess_ <= kAlike * excess;
}

double RegionShare::toleranceFor(double excess) {
  constexpr double kAimed = 0.9 * kMax;  // sections differ
  if (1 + excess <= kMax) return 1;
  return std::min(kCoarsest, std::pow((1 + excess) / kAimed, 1 / kNodePower));
}

// Viewers who came together would all be observed in the same keyframe for ever. The nodes of a section are as good as
// drawn at random, so they say how much sooner.
bool RegionShare::isDue(size_t nodes) {
  constexpr size_t kChange = 8;  // a part of the nodes
  const size_t change = std::max(nodes, nodes_) - std::min(nodes, nodes_);
  const uint32_t most = is_wide_ ? kOften : kSeldom;
  return ++keyframes_ >= most - nodes_ % (most / 2) || change > nodes_ / kChange;
}

// What errors add to a section is about proportional to their share.
void RegionShare::observe(const RegionParts& parts, size_t nodes, size_t without_errors) {
  constexpr double kWide = 1.2, kFall = 0.3, kRise = 1.3;
  observed_ = errorsOf(parts);
  nodes_ = nodes;
  keyframes_ = 0;
  excess_ = static_cast<double>(nodes) / static_cast<double>(std::max<size_t>(without_errors, 1)) - 1;
  is_wide_ = excess_ > kWide - 1 || share_ < 1;
  const double change = excess_ > 0 ? (kAim - 1) / excess_ : kRise;
  share_ = std::clamp(share_ * std::clamp(change, kFall, kRise), kLeast, 1.0);
}

}  // namespace foreland::server
