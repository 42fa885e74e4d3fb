#include "proto/refine/terrain_batch.h"

#include <algorithm>
#include <cmath>

#include "proto/refine/metric/motion_margin.h"
#include "proto/refine/metric/node_positions.h"
#include "proto/refine/metric/slack.h"

namespace foreland::proto {

// The loops, by runLoop(); AVX-512 pays for those that are bound by roots and divisions. What they read has memory of
// its own, or the compiler could not tell it from the batch, and would not vectorise.
struct TerrainBatch::Loops {
  template <class Positions>
  struct Test {
    TerrainBatch& b;
    const Metric& metric;
    const Positions& positions;
    [[gnu::always_inline]] void operator()(size_t begin, size_t end) const {
      TerrainBatch& batch = b;
      const Metric& m = metric;
      const Positions& p = positions;
      for (size_t i = begin; i < end; ++i)
        batch.passes[i] = m.passes(p(batch.x[i], batch.y[i], batch.height[i]), batch.radius[i], batch.error[i]);
    }
  };
  template <class Positions>
  struct Locate {
    TerrainBatch& b;
    const Positions& positions;
    [[gnu::always_inline]] void operator()(size_t begin, size_t end) const {
      TerrainBatch& batch = b;
      const Positions& at = positions;
      for (size_t i = begin; i < end; ++i) {
        const NodePosition p = at(batch.x[i], batch.y[i], batch.height[i]);
        batch.right_[i] = p.x;
        batch.up_[i] = p.y;
        batch.depth_[i] = p.z;
        batch.horizontal_[i] = p.horizontal;
      }
    }
  };
  // The inverse of the test gives a guess that is right but for rounding; `is_sure` says whether passes() agrees.
  struct GuessLeast {
    TerrainBatch& b;
    const Metric& metric;
    uint8_t* is_sure;
    [[gnu::always_inline]] void operator()(size_t begin, size_t end) const {
      TerrainBatch& batch = b;
      const Metric m = metric;
      uint8_t* const sure = is_sure;
      for (size_t i = begin; i < end; ++i) {
        const NodePosition p = batch.position(i);
        const double r = batch.radius[i], error_m = m.minError(p, r);
        const bool any = error_m < std::numeric_limits<double>::infinity();
        const int32_t guess = QuantisedError::roundUpFast(static_cast<float>(std::clamp(error_m, 0x1p-23, 0x1p80)));
        const uint8_t passes_it = m.passes(p, r, QuantisedError::metresFast(guess)),
                      passes_less = m.passes(p, r, QuantisedError::metresFast(guess - 1));
        batch.least[i] = static_cast<uint16_t>(any ? guess : kNonePasses);
        sure[i] = any ? passes_it & ~passes_less : 1;
      }
    }
  };
  struct TestWithSlack {
    TerrainBatch& b;
    const Metric& metric;
    const MotionBound& at_pace;
    [[gnu::always_inline]] void operator()(size_t begin, size_t end) const {
      TerrainBatch& batch = b;
      const MotionMargin margin(metric);
      const MotionBound pace = at_pace;
      for (size_t i = begin; i < end; ++i) {
        const NodePosition p = batch.position(i);
        const TestResult result = margin.testResult(p, batch.radius[i], batch.error[i], pace);
        const double safe = result.slack * kSlackShare;
        const double distance = std::max(std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z), Metric::kNearest_m);
        batch.passes[i] = margin.metric().passes(p, batch.radius[i], batch.error[i]);
        batch.slack[i] = static_cast<float>(safe);
        batch.constraint[i] = MotionConstraint::of(
            static_cast<uint32_t>(result.sensitivity),
            static_cast<float>(distance + MotionMargin::maxGrowthOfDistance(result.sensitivity, safe)));
      }
    }
  };
};

template <class Use>
void TerrainBatch::withPositions(const TerrainDomain& domain, const Metric& metric, const Use& use) {
  if (domain.isPlanar())
    use(PlanarPositions(domain, metric));
  else
    use(CurvedPositions(domain, metric));
}

void TerrainBatch::test(const TerrainDomain& domain, const Metric& metric, Vectors vectors) {
  lookUpErrors();
  withPositions(domain, metric, [&]<class Positions>(const Positions& positions) {
    runLoop<Vectors::kAvx2>(vectors, count, Loops::Test<Positions>{*this, metric, positions});
  });
  if (!metric.horizon().hidesAnything()) return;
  const CurvedPositions at(domain, metric);
  for (size_t i = 0; i < count; ++i)
    if (passes[i] && metric.horizon().hides(at(x[i], y[i], height[i]), radius[i])) passes[i] = 0;
}

void TerrainBatch::locate(const TerrainDomain& domain, const Metric& metric, Vectors vectors) {
  withPositions(domain, metric, [&]<class Positions>(const Positions& positions) {
    runLoop<Vectors::kAvx2>(vectors, count, Loops::Locate<Positions>{*this, positions});
  });
}

void TerrainBatch::findLeast(const Metric& metric, Vectors vectors) {
  std::array<uint8_t, kSize> is_sure;
  runLoop<Vectors::kAvx512>(vectors, count, Loops::GuessLeast{*this, metric, is_sure.data()});
  for (size_t i = 0; i < count; ++i)
    if (!is_sure[i]) least[i] = static_cast<uint16_t>(metric.leastPassing(position(i), radius[i]));
  if (!metric.horizon().hidesAnything()) return;
  for (size_t i = 0; i < count; ++i)
    if (least[i] != kNonePasses && metric.horizon().hides(position(i), radius[i])) least[i] = kNonePasses;
}

void TerrainBatch::testWithSlack(const Metric& metric, const MotionBound& motion, Vectors vectors) {
  lookUpErrors();
  const MotionBound pace = motion.isUnbounded() ? MotionBound::even() : motion;
  runLoop<Vectors::kAvx512>(vectors, count, Loops::TestWithSlack{*this, metric, pace});
  if (metric.isOverGlobe()) limitByHorizon(metric.horizon());
}

// A node that passes does so no longer than the horizon lets it. One that fails for that alone does so until then; if
// it fails in other ways, too, their slack will do.
void TerrainBatch::limitByHorizon(const Horizon& horizon) {
  for (size_t i = 0; i < count; ++i) {
    if (!passes[i]) continue;
    const NodePosition p = position(i);
    const double safe = horizon.slack(p, radius[i]) * kSlackShare;
    if (!horizon.hides(p, radius[i])) {
      slack[i] = std::min(slack[i], static_cast<float>(safe));
      continue;
    }
    passes[i] = 0;
    slack[i] = static_cast<float>(safe);
    const double distance = std::max(std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z), Metric::kNearest_m);
    constexpr auto kMotion = Sensitivity::kMotion;
    constraint[i] =
        MotionConstraint::of(static_cast<uint32_t>(kMotion),
                             static_cast<float>(distance + MotionMargin::maxGrowthOfDistance(kMotion, safe)));
  }
}

}  // namespace foreland::proto
