// Classes of bounds: they never understate, round up by one step at most, and keep order; records keep what they are
// given.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "base/rng.h"
#include "proto/section/bounds.h"
#include "proto/space/frame_grid.h"

namespace foreland::proto {
namespace {

TEST(QuantisedError, RoundsUpByAtMostAStepAndKeepsOrder) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  Rng rng(seed);
  const double step = std::exp2(1.0 / QuantisedError::kPerOctave) * 1.000001;
  for (int i = 0; i < 100000; ++i) {
    const double metres = std::exp2(rng.uniform(-23, 37)), other = metres * rng.uniform(1, 1.1);
    const QuantisedError c = QuantisedError::roundUp(metres);
    ASSERT_GE(c.metres(), metres) << "seed " << seed;
    ASSERT_LE(c.metres(), metres * step) << "seed " << seed;
    ASSERT_LE(c, QuantisedError::roundUp(other)) << "seed " << seed;
    ASSERT_EQ(QuantisedError::roundUp(c.metres()), c) << "seed " << seed;
  }
  EXPECT_EQ(QuantisedError::roundUp(0).value, 0);
  EXPECT_EQ(QuantisedError::roundUp(1).metres(), 1.0f);
  EXPECT_GT(QuantisedError::roundUp(5e-324).metres(), 0);
}

TEST(QuantisedError, FastConversionsAreTheSame) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  Rng rng(seed);
  for (int c = 1; c < 256; ++c) {
    const float metres = QuantisedError{static_cast<uint8_t>(c)}.metres();
    ASSERT_EQ(QuantisedError::metresFast(c), metres);
    ASSERT_EQ(QuantisedError::roundUpFast(metres), c);
    ASSERT_EQ(QuantisedError::roundUpFast(std::nextafter(metres, 0.0f)), c);
    ASSERT_EQ(QuantisedError::roundUpFast(std::nextafter(metres, 1e38f)), c + 1);
  }
  for (int i = 0; i < 100000; ++i) {
    const float metres = static_cast<float>(std::exp2(rng.uniform(-24, 37)));
    ASSERT_EQ(QuantisedError::roundUpFast(metres), QuantisedError::roundUp(metres).value) << "seed " << seed;
  }
}

TEST(SphereLevels, RoundsUpByAtMostAStepAndNestsLevelGround) {
  const GridTopology grid = *GridTopology::create({2, 3, 6, 120, 190});
  Frame frame;
  frame.axis_x_m = {30, 0};
  frame.axis_y_m = {5, 20};
  const SphereLevels spheres(grid, frame);
  Rng rng(2);
  for (int level = 1; level <= grid.maxLevel(); ++level)
    for (int i = 0; i < 1000; ++i) {
      const double radius = spheres.radius(level, {}) * std::exp2(rng.uniform(0, 8));
      const QuantisedRadius c = spheres.roundUp(level, radius);
      ASSERT_GE(spheres.radius(level, c), radius);
      ASSERT_LE(spheres.radius(level, c), radius * 1.18921);
    }
  for (Slot slot = 0; slot < grid.slotCount(); ++slot) {
    const NodeId n = grid.node(slot);
    if (grid.isBase(n)) continue;
    const FrameGrid positions(frame, grid.maxX(), grid.maxY());
    const int level = grid.level(n);
    for (NodeId child : grid.children(n))
      ASSERT_LE(glm::distance(positions.position(n, 0), positions.position(child, 0)) + spheres.radius(level + 1, {}),
                spheres.radius(level, {}));
  }
}

TEST(NodeRecord, KeepsWhatItIsGiven) {
  Rng rng(3);
  for (int i = 0; i < 10000; ++i) {
    const auto height = static_cast<int32_t>(rng.below(2 * kMaxHeight + 1)) - kMaxHeight;
    const auto displacement = static_cast<int32_t>(rng.below(1 << 24)) - (1 << 23);
    const QuantisedError error{static_cast<uint8_t>(rng.below(256))};
    const QuantisedRadius radius{static_cast<uint8_t>(rng.below(128))};
    const NodeRecord r = NodeRecord::of(height, displacement, error, radius);
    ASSERT_EQ(r.height(), height);
    ASSERT_EQ(r.displacement(), displacement);
    ASSERT_EQ(r.error(), error);
    ASSERT_EQ(r.radius(), radius);
    ASSERT_EQ(r.middle(), height - displacement);
  }
}

TEST(NodeRecord, KeepsTheSumOfItsEdgesEndsWhateverBecomesKnown) {
  Rng rng(4);
  for (int i = 0; i < 10000; ++i) {
    const auto height = [&] { return static_cast<int32_t>(rng.below(2 * kMaxHeight + 1)) - kMaxHeight; };
    const int32_t a = height(), b = height(), own = height();
    const QuantisedError error{static_cast<uint8_t>(rng.below(256))};
    const NodeRecord r = NodeRecord::ofEnds(a, b), known = r.withHeight(own), settled = known.withError(error);
    for (const NodeRecord& record : {r, known, settled}) {
      ASSERT_TRUE(record.hasEnds());
      ASSERT_EQ(record.ends(), a + b);
      ASSERT_EQ(record.middle(), middleOf(a, b));
    }
    ASSERT_EQ(settled.height(), own);
    ASSERT_EQ(settled.error(), error);
    ASSERT_FALSE(NodeRecord::of(own, 0, error, {static_cast<uint8_t>(rng.below(QuantisedRadius::kMax + 1))}).hasEnds());
  }
}

// A file may hold any byte.
TEST(QuantisedRadius, EveryByteHasAFactorAndThoseBeyondTheLargestHaveItsOwn) {
  float last = 0;
  for (int value = 0; value < 256; ++value) {
    const float factor = QuantisedRadius{static_cast<uint8_t>(value)}.factor();
    EXPECT_TRUE(factor > last || (value > QuantisedRadius::kMax && factor == last)) << value;
    last = factor;
  }
}

}  // namespace
}  // namespace foreland::proto
