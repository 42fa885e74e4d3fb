#include "proto/refine/surface_tester.h"

#include "proto/refine/metric/slack.h"

namespace foreland::proto {

void SurfaceTester::test() {
  for (size_t i = 0; i < count_; ++i) bounds_[i] = SurfaceBounds::of(records_[slot_[i]], quantum_m_);
  const SurfaceMetric m = metric_;  // its own memory, so that the loop vectorises
  for (size_t i = 0; i < count_; ++i) {
    const SurfaceMetric::TestResult result = m.testResult(bounds_[i]);
    const double safe = result.slack_m * kSlackShare;
    passes_[i] = result.passes;
    slack_[i] = static_cast<float>(safe);
    constraint_[i] = MotionConstraint::of(0, static_cast<float>(m.distance(bounds_[i]) + safe));
  }
}

}  // namespace foreland::proto
