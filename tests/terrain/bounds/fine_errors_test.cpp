#include "terrain/bounds/fine_errors.h"

#include <gtest/gtest.h>

#include "base/rng.h"
#include "terrain/bounds/error.h"

namespace foreland::terrain {
namespace {

// Both are exact, so they agree to the bit.
TEST(FineErrors, EqualTheErrorsOfOneNodeAtATime) {
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    const uint32_t width = 34 + static_cast<uint32_t>(rng.below(100)),
                   height = 34 + static_cast<uint32_t>(rng.below(60));
    const proto::GridShape shape{(width - 2) / 32 + 1, (height - 2) / 32 + 1, 5, width, height};
    const auto grid = *proto::GridTopology::create(shape);
    std::vector<int32_t> quanta(static_cast<size_t>(width) * height);
    for (int32_t& quantum : quanta) quantum = static_cast<int32_t>(rng.below(1u << 30)) - (1 << 29);
    const Heights heights{quanta, width, height};
    proto::Frame frame;
    frame.height_quantum_m = 1;
    const PlanarError reference(grid, frame, heights);
    uint64_t compared = 0;
    for (int number = grid.maxLevel(); number >= 1; --number) {
      const NodeLevel level(grid, number);
      if (level.s > FineErrors::kLargestReach) continue;
      FineErrors fine(grid, heights, level);
      std::vector<double> errors(level.cells_x + 1);
      for (uint32_t y = level.sides ? 0 : level.s; y <= grid.maxY(); y += level.sides ? level.s : 2 * level.s) {
        const NodeRow row = level.row(y);
        const auto [first, last] = fine.compute(row, errors);
        for (uint32_t i = first; i < last; ++i, ++compared)
          ASSERT_EQ(reference.inMetres(errors[i]), reference.metres(row.node(i)))
              << "level " << number << ", node " << i << ", row " << y;
      }
    }
    EXPECT_GT(compared, uint64_t{width} * height / 2);
  }
}

}  // namespace
}  // namespace foreland::terrain
