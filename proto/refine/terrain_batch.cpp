#include "proto/refine/terrain_batch.h"

#include <algorithm>
#include <cmath>

#include "proto/refine/motion_margin.h"
#include "proto/refine/node_positions.h"
#include "proto/refine/slack.h"

namespace foreland::proto {

namespace {

// Not inlined into callers that keep batch and metric in one object: the compiler could not tell their memory apart
// there, and would not vectorise.
template <class Positions>
void testAll(TerrainBatch& b, const Metric& metric, const Positions& positions) {
  for (size_t i = 0; i < b.count; ++i)
    b.passes[i] = metric.passes(positions(b.x[i], b.y[i], b.height[i]), b.radius[i], b.error[i]);
}

}  // namespace

void TerrainBatch::test(const TerrainDomain& domain, const Metric& metric) {
  lookUpErrors();
  if (domain.isPlanar())
    testAll(*this, metric, PlanarPositions(domain, metric));
  else
    testAll(*this, metric, CurvedPositions(domain, metric));
}

void TerrainBatch::locate(const TerrainDomain& domain, const Metric& metric) {
  const auto locateAll = [this](const auto& positions) {
    for (size_t i = 0; i < count; ++i) {
      const NodePosition p = positions(x[i], y[i], height[i]);
      right_[i] = p.x;
      up_[i] = p.y;
      depth_[i] = p.z;
      horizontal_[i] = p.horizontal;
    }
  };
  if (domain.isPlanar())
    locateAll(PlanarPositions(domain, metric));
  else
    locateAll(CurvedPositions(domain, metric));
}

// The inverse of the test gives a guess that is right but for rounding; passes() corrects it.
void TerrainBatch::findLeast(const Metric& metric) {
  const Metric m = metric;  // its own memory, so that the loop vectorises
  std::array<uint8_t, kSize> is_sure;
  for (size_t i = 0; i < count; ++i) {
    const NodePosition p = position(i);
    const double r = radius[i], error_m = m.leastError(p, r);
    const bool any = error_m < std::numeric_limits<double>::infinity();
    const int32_t guess = QuantisedError::roundUpFast(static_cast<float>(std::clamp(error_m, 0x1p-23, 0x1p80)));
    const uint8_t passes_it = m.passes(p, r, QuantisedError::metresFast(guess)),
                  passes_less = m.passes(p, r, QuantisedError::metresFast(guess - 1));
    least[i] = static_cast<uint16_t>(any ? guess : kNonePasses);
    is_sure[i] = any ? passes_it & ~passes_less : 1;
  }
  for (size_t i = 0; i < count; ++i)
    if (!is_sure[i]) least[i] = static_cast<uint16_t>(m.leastPassing(position(i), radius[i]));
}

void TerrainBatch::testWithSlack(const Metric& metric, const MotionBound& motion) {
  lookUpErrors();
  const MotionMargin margin(metric);  // with a metric in its own memory, so that the loop vectorises
  const MotionBound pace = motion.isUnbounded() ? MotionBound::even() : motion;
  const size_t n = count;  // a copy, for the bytes written might be its own
  for (size_t i = 0; i < n; ++i) {
    const NodePosition p = position(i);
    const TestResult result = margin.testResult(p, radius[i], error[i], pace);
    const double safe = result.slack * kSlackShare;
    const double distance = std::max(std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z), Metric::kNearest_m);
    passes[i] = margin.metric().passes(p, radius[i], error[i]);
    slack[i] = static_cast<float>(safe);
    constraint[i] =
        MotionConstraint::of(static_cast<uint32_t>(result.sensitivity), static_cast<float>(distance + safe));
  }
}

}  // namespace foreland::proto
