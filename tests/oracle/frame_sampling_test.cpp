#include "oracle/frame_sampling.h"

#include <gtest/gtest.h>

namespace foreland::oracle {
namespace {

// With any stride that is asked for, every frame between two keyframes is judged in its turn.
TEST(CoprimeStride, JudgesEveryWeight) {
  for (uint32_t frames = 1; frames <= 60; ++frames)
    for (uint32_t asked = 1; asked <= 30; ++asked) {
      const uint32_t stride = coprimeStride(asked, frames);
      EXPECT_GE(stride, asked);
      JudgedWeights weights;
      for (uint32_t frame = 0; frame < stride * frames; frame += stride)
        weights.add(static_cast<double>(frame % frames) / frames);
      EXPECT_EQ(weights.distinct(), frames) << "every " << asked << " of " << frames;
    }
  EXPECT_EQ(coprimeStride(6, 12), 7u);
}

TEST(JudgedWeights, TellTheirRange) {
  JudgedWeights weights;
  EXPECT_EQ(weights.distinct(), 0u);
  for (double w : {0.5, 0.25, 0.2500001, 1.0}) weights.add(w);
  EXPECT_EQ(weights.distinct(), 3u);
  EXPECT_EQ(weights.least(), 0.25);
  EXPECT_EQ(weights.largest(), 1);
}

}  // namespace
}  // namespace foreland::oracle
