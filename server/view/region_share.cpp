#include "server/view/region_share.h"

#include <algorithm>

namespace foreland::server {

Region RegionShare::of(const RegionParts& parts) const {
  const auto& [motion, error, rest] = parts;
  const double of_motion = std::min(1.0, 2 * share_), of_error = std::max(0.0, 2 * share_ - 1);
  return {of_motion * motion.radius_m + of_error * error.radius_m + rest.radius_m,
          of_motion * motion.angle_rad + of_error * error.angle_rad + rest.angle_rad};
}

double RegionShare::shareOf(const RegionParts& parts) const {
  const Region left = of(parts), whole = RegionShare().of(parts);
  const auto share = [](double part, double all) { return all > 0 ? part / all : 1.0; };
  return std::min(share(left.radius_m, whole.radius_m), share(left.angle_rad, whole.angle_rad));
}

double RegionShare::expectedExcess(const Region& region) const {
  constexpr double kMin = 0.01;  // sections of small regions differ by chance
  constexpr double kRadius_m = 1e-3, kAngle_rad = 1e-5;
  const double growth = std::max(region.radius_m / std::max(observed_.radius_m, kRadius_m),
                                 region.angle_rad / std::max(observed_.angle_rad, kAngle_rad));
  return growth * std::max(excess_, kMin);
}

// Viewers who came together would all be observed in the same keyframe for ever. The nodes of a section are as good as
// drawn at random, so they say how much sooner.
bool RegionShare::isDue(size_t nodes) {
  constexpr size_t kChange = 8;  // a part of the nodes
  const size_t change = std::max(nodes, nodes_) - std::min(nodes, nodes_);
  const uint32_t most = is_wide_ ? kOften : kSeldom;
  return ++keyframes_ >= most - nodes_ % (most / 2) || change > nodes_ / kChange;
}

// What the region adds to a section is about proportional to its share.
void RegionShare::observe(const Region& region, size_t nodes, size_t pose_alone) {
  constexpr double kWide = 1.2, kMin = 1.0 / 1024, kFall = 0.3, kRise = 1.3;
  observed_ = region;
  nodes_ = nodes;
  keyframes_ = 0;
  excess_ = static_cast<double>(nodes) / static_cast<double>(std::max<size_t>(pose_alone, 1)) - 1;
  is_wide_ = excess_ > kWide - 1 || share_ < 1;
  const double change = excess_ > 0 ? (kAim - 1) / excess_ : kRise;
  share_ = std::clamp(share_ * std::clamp(change, kFall, kRise), kMin, 1.0);
}

}  // namespace foreland::server
