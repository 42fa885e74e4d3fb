// Every kind of vectors that this processor has against one node after another.
#include "proto/refine/terrain_batch.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <memory>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::proto {
namespace {

TerrainDomain makeDomain(FrameKind kind) {
  Frame frame;
  frame.kind = kind;
  frame.axis_x_m = {10, 0};
  frame.axis_y_m = {0, 10};
  frame.longitude_step_rad = frame.latitude_step_rad = 1.5e-6;
  return TerrainDomain(std::move(GridTopology::create({1, 1, 8, 257, 257})).value(), frame);
}

View randomView(Rng& rng) {
  View view;
  view.pose.eye = {rng.uniform(0, 2570), rng.uniform(0, 2570), rng.uniform(-10, 800)};
  view.tau_px = rng.uniform(0.3, 8);
  view.region_radius_m = rng.below(2) ? rng.uniform(0, 20) : 0;
  view.region_angle_rad = rng.below(2) ? rng.uniform(0, 0.4) : 0;
  return view;
}

void fill(Rng& rng, TerrainBatch& batch) {
  batch.count = 0;
  for (size_t left = rng.below(TerrainBatch::kSize + 1); left > 0; --left) {
    const NodeId n = NodeId::at(static_cast<uint32_t>(rng.below(257)), static_cast<uint32_t>(rng.below(257)));
    batch.height[batch.count] = static_cast<int32_t>(rng.below(8000));
    batch.push(n, 0, 1, {static_cast<uint8_t>(rng.below(100))}, static_cast<float>(rng.uniform(0, 200)));
  }
}

void expectSame(const TerrainBatch& a, const TerrainBatch& b) {
  for (size_t i = 0; i < a.count; ++i) {
    ASSERT_EQ(a.least[i], b.least[i]);
    ASSERT_EQ(a.passes[i], b.passes[i]);
    ASSERT_EQ(std::bit_cast<uint32_t>(a.slack[i]), std::bit_cast<uint32_t>(b.slack[i]));
    ASSERT_EQ(a.constraint[i].bits, b.constraint[i].bits);
  }
}

TEST(TerrainBatch, GivesTheSameBitsByAllVectors) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  const auto scalar = std::make_unique<TerrainBatch>(), other = std::make_unique<TerrainBatch>();
  size_t passed = 0, tested = 0;
  for (int round = 0; round < 400; ++round) {
    const TerrainDomain domain = makeDomain(round % 2 == 0 ? FrameKind::kPlanar : FrameKind::kGeographic);
    const Metric metric = domain.metric(randomView(rng));
    MotionBound motion;
    for (size_t g = 0; g < MotionBound::kSensitivities; ++g) motion.set(g, rng.uniform(0, 2), rng.uniform(0, 1e-3));
    fill(rng, *scalar);
    *other = *scalar;
    const auto run = [&](TerrainBatch& batch, Vectors vectors) {
      batch.test(domain, metric, vectors);
      const std::array<uint8_t, TerrainBatch::kSize> passes = batch.passes;
      batch.locate(domain, metric, vectors);
      batch.findLeast(metric, vectors);
      batch.testWithSlack(metric, motion, vectors);
      for (size_t i = 0; i < batch.count; ++i) ASSERT_EQ(batch.passes[i], passes[i]);
    };
    run(*scalar, Vectors::kScalar);
    for (const Vectors vectors : kAllVectors) {
      if (vectors > widestVectors()) break;
      SCOPED_TRACE("vectors " + std::to_string(static_cast<int>(vectors)));
      run(*other, vectors);
      expectSame(*scalar, *other);
      if (HasFatalFailure()) return;
    }
    tested += scalar->count;
    for (size_t i = 0; i < scalar->count; ++i) passed += scalar->passes[i];
  }
  EXPECT_GT(passed, tested / 100);
  EXPECT_LT(passed, tested);
}

}  // namespace
}  // namespace foreland::proto
