#include "proto/refine/metric/metric.h"

namespace foreland::proto {

Metric::Metric(const View& view, bool vertical_errors)
    : frustum_(view, kNearest_m),
      eye_(view.pose.eye),
      focal_over_tau_(view.lens.focalPx() / view.tau_px),
      any_direction_(vertical_errors ? 0 : std::numeric_limits<double>::infinity()),
      region_radius_(view.region_radius_m) {}

Metric::Metric(const View& view, const Frame& globe, double ceiling_m) : Metric(view, false) {
  horizon_ = Horizon(globe, ceiling_m, view, frustum_);
  is_over_globe_ = true;
}

int Metric::leastPassing(const NodePosition& p, double radius_m) const {
  const double guess_m = minError(p, radius_m);
  if (guess_m == std::numeric_limits<double>::infinity()) return 256;
  int c = QuantisedError::roundUp(std::min(guess_m, 1e9)).value;  // the loops below make it exact
  const auto passesAt = [&](int k) { return passes(p, radius_m, QuantisedError{static_cast<uint8_t>(k)}.metres()); };
  while (c < 256 && !passesAt(c)) ++c;
  while (c > 0 && c < 256 && passesAt(c - 1)) --c;
  return c;
}

}  // namespace foreland::proto
