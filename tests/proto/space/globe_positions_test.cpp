// The same number as WebAssembly's (client/js/tests/globe_positions.test.mjs).
#include "tests/proto/space/globe_positions.h"

#include <gtest/gtest.h>

namespace foreland::proto {
namespace {

TEST(GlobePositions, AreTheSameBitsInEveryBuild) {
  EXPECT_EQ(hashOfGlobePositions(kGlobePositions), kHashOfGlobePositions);
}

}  // namespace
}  // namespace foreland::proto
