#include "server/session/plan/adaptive_interval.h"

#include <algorithm>

namespace foreland::server {

// Rises at once and falls slowly, like the interval that follows from it.
void AdaptiveInterval::observe(size_t changed, size_t nodes, Duration interval) {
  constexpr double kKept = 0.5;
  const double share = static_cast<double>(changed) / static_cast<double>(std::max<size_t>(nodes, 1));
  const double now = share / std::max(1e-3, interval.toSeconds());
  share_per_s_ = std::max(now, share_per_s_ < 0 ? now : kKept * share_per_s_ + (1 - kKept) * now);
}

Duration AdaptiveInterval::next(const proto::KeyframeInterval& bounds, Duration before) const {
  if (!bounds.isAdaptive() || share_per_s_ < 0) return bounds.shortest;
  const double shortest_s = bounds.shortest.toSeconds();
  const double wanted = kShare / std::max(1e-9, share_per_s_ * shortest_s);
  const int64_t most = std::min(bounds.longest.us, before.us + bounds.shortest.us) / bounds.shortest.us;
  return bounds.shortest *
         static_cast<int64_t>(std::clamp(wanted, 1.0, static_cast<double>(std::max<int64_t>(most, 1))));
}

Duration AdaptiveInterval::shortened(const proto::KeyframeInterval& bounds, Duration interval, double share) {
  if (!bounds.isAdaptive() || share >= 1) return interval;
  const double steps = share * interval.toSeconds() / bounds.shortest.toSeconds();
  return std::min(interval, bounds.shortest * std::max<int64_t>(1, static_cast<int64_t>(steps)));
}

}  // namespace foreland::server
