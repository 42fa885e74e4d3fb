#include "server/section/batch.h"

#include <algorithm>
#include <cmath>

namespace foreland::server {

template <class Places>
void Batch::test(const Metric& metric, const Places& places) {
  for (size_t i = 0; i < count; ++i) passes[i] = metric.passes(places(x[i], y[i], height[i]), radius[i], error[i]);
}

template <class Places>
void Batch::testWithSlack(const Metric& metric, const Places& places, double share) {
  for (size_t i = 0; i < count; ++i) {
    const Metric::Place p = places(x[i], y[i], height[i]);
    const Metric::Outcome outcome = metric.outcome(p, radius[i], error[i]);
    const double safe = outcome.slack * share;
    guard[i] = static_cast<uint8_t>(outcome.guard);
    slack[i] = static_cast<float>(safe);
    reach[i] = static_cast<float>(std::max(std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z), Metric::kNearest_m) + safe);
  }
}

template void Batch::test(const Metric&, const PlanarPlaces&);
template void Batch::test(const Metric&, const CurvedPlaces&);
template void Batch::testWithSlack(const Metric&, const PlanarPlaces&, double);
template void Batch::testWithSlack(const Metric&, const CurvedPlaces&, double);

}  // namespace foreland::server
