#include "proto/refine/terrain_batch.h"

#include <algorithm>
#include <cmath>

#include "proto/refine/metric/motion_margin.h"
#include "proto/refine/metric/node_positions.h"
#include "proto/refine/metric/slack.h"

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

// The loops, to be inlined into functions for different instructions.
struct TerrainBatch::Loops {
  // The inverse of the test gives a guess that is right but for rounding; `is_sure` says whether passes() agrees.
  [[gnu::always_inline]] static inline void guessLeast(TerrainBatch& b, const Metric& metric, uint8_t* is_sure) {
    const Metric m = metric;  // its own memory, so that the loop vectorises
    const size_t n = b.count;
    for (size_t i = 0; i < n; ++i) {
      const NodePosition p = b.position(i);
      const double r = b.radius[i], error_m = m.minError(p, r);
      const bool any = error_m < std::numeric_limits<double>::infinity();
      const int32_t guess = QuantisedError::roundUpFast(static_cast<float>(std::clamp(error_m, 0x1p-23, 0x1p80)));
      const uint8_t passes_it = m.passes(p, r, QuantisedError::metresFast(guess)),
                    passes_less = m.passes(p, r, QuantisedError::metresFast(guess - 1));
      b.least[i] = static_cast<uint16_t>(any ? guess : kNonePasses);
      is_sure[i] = any ? passes_it & ~passes_less : 1;
    }
  }
  [[gnu::always_inline]] static inline void testWithSlack(TerrainBatch& b, const Metric& metric,
                                                          const MotionBound& at_pace) {
    const MotionMargin margin(metric);  // all in memory of their own, so that the loop vectorises
    const MotionBound pace = at_pace;
    const size_t n = b.count;
    for (size_t i = 0; i < n; ++i) {
      const NodePosition p = b.position(i);
      const TestResult result = margin.testResult(p, b.radius[i], b.error[i], pace);
      const double safe = result.slack * kSlackShare;
      const double distance = std::max(std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z), Metric::kNearest_m);
      b.passes[i] = margin.metric().passes(p, b.radius[i], b.error[i]);
      b.slack[i] = static_cast<float>(safe);
      b.constraint[i] = MotionConstraint::of(
          static_cast<uint32_t>(result.sensitivity),
          static_cast<float>(distance + MotionMargin::maxGrowthOfDistance(result.sensitivity, safe)));
    }
  }

  static void guessLeastBuilt(TerrainBatch& b, const Metric& m, uint8_t* is_sure) { guessLeast(b, m, is_sure); }
  static void testWithSlackBuilt(TerrainBatch& b, const Metric& m, const MotionBound& p) { testWithSlack(b, m, p); }
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
  [[gnu::target("avx512f,avx512dq,avx512bw,avx512vl,prefer-vector-width=512")]] static void guessLeastWide(
      TerrainBatch& b, const Metric& m, uint8_t* is_sure) {
    guessLeast(b, m, is_sure);
  }
  [[gnu::target("avx512f,avx512dq,avx512bw,avx512vl,prefer-vector-width=512")]] static void testWithSlackWide(
      TerrainBatch& b, const Metric& m, const MotionBound& p) {
    testWithSlack(b, m, p);
  }
  static bool hasWide() {
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
  }
#else
  static constexpr auto guessLeastWide = guessLeastBuilt;
  static constexpr auto testWithSlackWide = testWithSlackBuilt;
  static bool hasWide() { return false; }
#endif
};

Vectors TerrainBatch::widestVectors() {
  static const Vectors widest = Loops::hasWide() ? Vectors::kWide : Vectors::kBuilt;
  return widest;
}

void TerrainBatch::findLeast(const Metric& metric, Vectors vectors) {
  std::array<uint8_t, kSize> is_sure;
  (vectors == Vectors::kWide ? Loops::guessLeastWide : Loops::guessLeastBuilt)(*this, metric, is_sure.data());
  for (size_t i = 0; i < count; ++i)
    if (!is_sure[i]) least[i] = static_cast<uint16_t>(metric.leastPassing(position(i), radius[i]));
}

void TerrainBatch::testWithSlack(const Metric& metric, const MotionBound& motion, Vectors vectors) {
  lookUpErrors();
  const MotionBound pace = motion.isUnbounded() ? MotionBound::even() : motion;
  (vectors == Vectors::kWide ? Loops::testWithSlackWide : Loops::testWithSlackBuilt)(*this, metric, pace);
}

}  // namespace foreland::proto
