#include "proto/refine/terrain_batch.h"

#include <algorithm>
#include <cmath>

#include "proto/refine/entry_pool.h"
#include "proto/refine/places.h"

namespace foreland::proto {

namespace {

// Called through the linker: inlined into a caller that keeps batch and metric in one object, the compiler could not
// tell their memory apart and would not vectorise.
template <class Places>
void testAll(TerrainBatch& b, const Metric& metric, const Places& places) {
  for (size_t i = 0; i < b.count; ++i)
    b.passes[i] = metric.passes(places(b.x[i], b.y[i], b.height[i]), b.radius[i], b.error[i]);
}

}  // namespace

void TerrainBatch::test(const TerrainDomain& domain, const Metric& metric) {
  lookUpErrors();
  if (domain.isPlanar())
    testAll(*this, metric, PlanarPlaces(domain, metric));
  else
    testAll(*this, metric, CurvedPlaces(domain, metric));
}

void TerrainBatch::locate(const TerrainDomain& domain, const Metric& metric) {
  const auto locateAll = [this](const auto& places) {
    for (size_t i = 0; i < count; ++i) {
      const Metric::Place p = places(x[i], y[i], height[i]);
      right_[i] = p.x;
      up_[i] = p.y;
      depth_[i] = p.z;
      horizontal_[i] = p.horizontal;
    }
  };
  if (domain.isPlanar())
    locateAll(PlanarPlaces(domain, metric));
  else
    locateAll(CurvedPlaces(domain, metric));
}

// By a guess that is right but for rounding; passes() itself decides.
void TerrainBatch::findLeast(const Metric& metric) {
  const Metric m = metric;  // its own memory
  std::array<uint8_t, kSize> is_sure;
  for (size_t i = 0; i < count; ++i) {
    const Metric::Place p = place(i);
    const double r = radius[i], error_m = m.leastError(p, r);
    const bool any = error_m < std::numeric_limits<double>::infinity();
    const int32_t guess = QuantisedError::roundUpFast(static_cast<float>(std::clamp(error_m, 0x1p-23, 0x1p80)));
    const uint8_t passes_it = m.passes(p, r, QuantisedError::metresFast(guess)),
                  passes_less = m.passes(p, r, QuantisedError::metresFast(guess - 1));
    least[i] = static_cast<uint16_t>(any ? guess : 256);
    is_sure[i] = any ? passes_it & ~passes_less : 1;
  }
  for (size_t i = 0; i < count; ++i)
    if (!is_sure[i]) least[i] = static_cast<uint16_t>(m.leastPassing(place(i), radius[i]));
}

void TerrainBatch::testWithSlack(const Metric& metric, const MotionBound& motion, double share) {
  lookUpErrors();
  const Metric m = metric;  // its own memory
  const MotionBound pace = motion.isUnbounded() ? MotionBound::even() : motion;
  const size_t n = count;  // bytes are written, which might be anything's
  for (size_t i = 0; i < n; ++i) {
    const Metric::Place p = place(i);
    const Metric::TestResult testResult = m.testResult(p, radius[i], error[i], pace);
    const double safe = testResult.slack * share;
    const double distance = std::max(std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z), Metric::kNearest_m);
    passes[i] = m.passes(p, radius[i], error[i]);
    slack[i] = static_cast<float>(safe);
    constraint[i] =
        Entry::constraint(static_cast<float>(distance + safe), static_cast<uint32_t>(testResult.sensitivity));
  }
}

}  // namespace foreland::proto
