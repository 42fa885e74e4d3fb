// Heights of a tile as bytes: whatever is coded is decoded, and any bytes end in heights or in an error.
#include "proto/imagery/relief_codec.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::proto {
namespace {

using Steps = std::vector<int32_t>;

Steps tileOf(const std::function<int32_t(uint32_t x, uint32_t y)>& height) {
  Steps steps;
  for (uint32_t y = 0; y < kTileSide; ++y)
    for (uint32_t x = 0; x < kTileSide; ++x) steps.push_back(height(x, y));
  return steps;
}

void expectRoundTrip(const Steps& steps, const char* what) {
  const Bytes bytes = encodeRelief(steps);
  Steps decoded(kTileTexels, 77);
  ASSERT_TRUE(decodeRelief(bytes, decoded).ok()) << what;
  EXPECT_EQ(decoded, steps) << what;
  EXPECT_LE(bytes.size(), size_t{kMaxTileBytes}) << what;
}

TEST(ReliefCodec, GivesBackAnyHeights) {
  Rng rng(test::randomSeed());
  for (int round = 0; round < 6; ++round) {
    const uint64_t most = uint64_t{2} << rng.below(29);
    expectRoundTrip(tileOf([&](uint32_t, uint32_t) {
                      const auto height = static_cast<int64_t>(rng.below(most + 1)) - static_cast<int64_t>(most / 2);
                      return static_cast<int32_t>(std::clamp<int64_t>(height, -kMaxReliefSteps, kMaxReliefSteps));
                    }),
                    "noise");
    const double slope = rng.uniform(-200, 200), bend = rng.uniform(-2, 2);
    expectRoundTrip(tileOf([&](uint32_t x, uint32_t y) {
                      return static_cast<int32_t>(slope * x + bend * y * y + static_cast<double>(rng.below(3)));
                    }),
                    "a slope");
  }
}

TEST(ReliefCodec, GivesBackTheHighestAndLowestHeights) {
  expectRoundTrip(tileOf([](uint32_t, uint32_t) { return kMaxReliefSteps; }), "highest");
  expectRoundTrip(tileOf([](uint32_t, uint32_t) { return -kMaxReliefSteps; }), "lowest");
  expectRoundTrip(tileOf([](uint32_t x, uint32_t y) { return (x + y) % 2 ? kMaxReliefSteps : -kMaxReliefSteps; }),
                  "a board");
  Rng rng(test::randomSeed());
  expectRoundTrip(tileOf([&](uint32_t, uint32_t) { return rng.below(2) ? kMaxReliefSteps : -kMaxReliefSteps; }),
                  "random extremes");
}

TEST(ReliefCodec, LevelGroundTakesNextToNothing) {
  EXPECT_LT(encodeRelief(tileOf([](uint32_t, uint32_t) { return 4000; })).size(), 500u);
}

TEST(ReliefCodec, AnyBytesEndInHeightsOrInAnError) {
  Rng rng(test::randomSeed());
  Steps steps(kTileTexels);
  const Bytes sound = encodeRelief(tileOf([&](uint32_t x, uint32_t y) {
    return static_cast<int32_t>(300 * std::sin(x * 0.05) + 200 * std::cos(y * 0.03) +
                                static_cast<double>(rng.below(4)));
  }));
  for (int i = 0; i < 60; ++i) {
    Bytes bytes = sound;
    if (i % 3 == 0) bytes.assign(rng.below(2000), 0);
    for (int change = 0; change < 4 && !bytes.empty(); ++change)
      bytes[rng.below(bytes.size())] = static_cast<uint8_t>(rng.next());
    if (i % 3 == 0)
      for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(rng.next());
    if (i % 3 == 2) bytes.resize(rng.below(bytes.size()));
    if (!decodeRelief(bytes, steps).ok()) continue;
    for (const int32_t height : steps) ASSERT_LE(std::abs(height), kMaxReliefSteps);
  }
}

TEST(ReliefCodec, BytesThatAreTooShortOrTooLongAreRefused) {
  Rng rng(test::randomSeed());
  Steps steps(kTileTexels);
  Bytes bytes = encodeRelief(tileOf([&](uint32_t, uint32_t) { return static_cast<int32_t>(rng.below(1000)); }));
  EXPECT_FALSE(decodeRelief(ByteSpan(bytes).first(bytes.size() / 2), steps).ok());
  EXPECT_FALSE(decodeRelief(ByteSpan(), steps).ok());
  bytes.insert(bytes.end(), 8, 1);
  EXPECT_FALSE(decodeRelief(bytes, steps).ok());
}

}  // namespace
}  // namespace foreland::proto
