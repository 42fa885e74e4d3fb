#include "proto/refine/surface_batch.h"

#include "proto/refine/entry_pool.h"

namespace foreland::proto {

void SurfaceBatch::locate(const SurfaceDomain& domain, const SurfaceMetric& metric) {
  for (size_t i = 0; i < count; ++i) {
    bounds_[i] = SurfaceBounds::of(record[i], domain.step_m);
    distance_[i] = metric.distance(bounds_[i]);
  }
}

void SurfaceBatch::findLeast(const SurfaceMetric& metric) {
  const SurfaceMetric m = metric;  // its own memory
  for (size_t i = 0; i < count; ++i) least[i] = m.passes(bounds_[i]) ? 0 : 256;
}

void SurfaceBatch::testWithSlack(const SurfaceMetric& metric, const MotionBound&, double share) {
  const SurfaceMetric m = metric;  // its own memory
  for (size_t i = 0; i < count; ++i) {
    const SurfaceMetric::TestResult testResult = m.testResult(bounds_[i]);
    const double safe = testResult.slack_m * share;
    passes[i] = testResult.passes;
    slack[i] = static_cast<float>(safe);
    constraint[i] = Entry::constraint(static_cast<float>(distance_[i] + safe), 0);
  }
}

}  // namespace foreland::proto
