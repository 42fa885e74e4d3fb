// Every kind of vectors that this processor has against one bin after another.
#include "server/occlusion/horizon/horizon_line.h"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::server {
namespace {

constexpr size_t kBins = HorizonLine::kBins;

// Heights of a line, with eight more that may be read, and where bins begin.
struct Cut {
  std::vector<uint16_t> heights;
  int count;
  float first, step;
  int halo;

  explicit Cut(Rng& rng) : count(static_cast<int>(2 + rng.below(300))) {
    for (int i = 0; i < count + 8; ++i) heights.push_back(static_cast<uint16_t>(rng.below(65536)));
    first = static_cast<float>(rng.uniform(-200, 1.0 * count));
    step = static_cast<float>(rng.uniform(0.001, HorizonLine::kMaxStep));
    halo = static_cast<int>(rng.below(HorizonLine::kMaxHalo + 1));
  }
  std::array<float, kBins> raise(std::array<float, kBins> slopes, Vectors vectors) const {
    HorizonLine line(vectors);
    line.findLeast({heights.data(), count}, first, step, static_cast<int>(kBins) + halo);
    line.widen(halo);
    line.raise(20'000, 0.01f, 0.02f, slopes);
    return slopes;
  }
};

TEST(HorizonLine, GivesTheSameBitsByAllVectors) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  int raised = 0;
  for (int round = 0; round < 3000; ++round) {
    const Cut cut(rng);
    std::array<float, kBins> slopes;
    for (float& slope : slopes) slope = rng.below(2) == 0 ? HorizonLine::kNone : static_cast<float>(rng.uniform(-9, 9));
    const std::array<float, kBins> expected = cut.raise(slopes, Vectors::kScalar);
    std::array<int16_t, kBins> rounded, expected_rounded;
    HorizonLine::round(expected, 100, expected_rounded.data(), Vectors::kScalar);
    for (const Vectors vectors : kAllVectors) {
      if (vectors > widestVectors()) break;
      const std::array<float, kBins> found = cut.raise(slopes, vectors);
      ASSERT_EQ(std::memcmp(found.data(), expected.data(), sizeof(found)), 0) << static_cast<int>(vectors);
      HorizonLine::round(expected, 100, rounded.data(), vectors);
      ASSERT_EQ(rounded, expected_rounded);
    }
    for (size_t k = 0; k < kBins; ++k) raised += expected[k] > slopes[k] ? 1 : 0;
  }
  EXPECT_GT(raised, 3000);
}

}  // namespace
}  // namespace foreland::server
