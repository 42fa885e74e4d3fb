// What is asked of a segment of a horizon does not depend on what was asked of it before.
#include "server/occlusion/horizon/horizon_side.h"

#include <gtest/gtest.h>

#include <array>

#include "base/rng.h"
#include "tests/support/height_field.h"
#include "tests/support/scene.h"

namespace foreland::server {
namespace {

// A segment goes on from where it was built to, and its memory is used again for other eyes.
TEST(HorizonSides, HaveTheSameSlopesInWhateverOrderTheyAreAsked) {
  const auto seed = static_cast<uint64_t>(testing::UnitTest::GetInstance()->random_seed());
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Rng rng(seed);
  const Hierarchy hierarchy(test::makeScene(257, 257, 7));
  const test::HeightField field(hierarchy);
  const HorizonGrid grid(hierarchy);
  std::array<HorizonSide, 4> used;
  int hiding = 0, tried = 0;
  for (int round = 0; round < 60; ++round) {
    const glm::dvec2 begin(rng.uniform(90, 166), rng.uniform(90, 166));  // ground on all sides
    const HorizonEyes eyes{begin,
                           {rng.uniform(-4, 4), rng.uniform(-4, 4)},
                           rng.uniform(0, 3),
                           field.at(begin.x, begin.y) + rng.uniform(5, 300)};
    for (uint32_t number = 0; number < used.size(); ++number) {
      const double bin = 0.001 * static_cast<double>(1 + rng.below(4));
      used[number].look(grid, eyes, number, bin);
      for (int i = 0; i < 60; ++i) {
        const auto at = static_cast<uint32_t>(rng.below(used[number].binCount()));
        const double ahead = HorizonSide::kNearest * std::exp2(rng.uniform(0, 8));
        HorizonSide fresh;
        fresh.look(grid, eyes, number, bin);
        const int slope = fresh.slope(at, ahead);
        ASSERT_EQ(used[number].slope(at, ahead), slope) << number << ", bin " << at << ", " << ahead << " steps ahead";
        hiding += slope > HorizonSide::kMinSlope ? 1 : 0;
        ++tried;
      }
    }
  }
  EXPECT_GT(hiding, tried / 4);
}

}  // namespace
}  // namespace foreland::server
