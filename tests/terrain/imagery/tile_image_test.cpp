#include "terrain/imagery/tile_image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "base/rng.h"
#include "terrain/imagery/imagery.h"
#include "terrain/imagery/webp.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

constexpr uint32_t kSide = proto::kTileSide;

template <class Formula>
std::vector<Rgba> tileOf(const Formula& formula) {
  std::vector<Rgba> texels;
  for (uint32_t y = 0; y < kSide; ++y)
    for (uint32_t x = 0; x < kSide; ++x) texels.push_back(formula(x, y));
  return texels;
}

double psnr(const std::vector<Rgb>& a, const std::vector<Rgb>& b) {
  double squares = 0;
  for (size_t i = 0; i < a.size(); ++i)
    for (size_t k = 0; k < 3; ++k) squares += std::pow(a[i][k] - b[i][k], 2);
  return 10 * std::log10(255 * 255 * 3.0 * static_cast<double>(a.size()) / squares);
}

std::vector<Rgba> hills() {
  return tileOf([](uint32_t x, uint32_t y) {
    const auto wave = [&](double k, double phase) {
      return static_cast<uint8_t>(std::lround(128 + 90 * std::sin(k * x + phase) * std::cos(0.7 * k * y)));
    };
    return Rgba{wave(0.05, 0), wave(0.03, 1), wave(0.08, 2), 255};
  });
}

TEST(TileImage, EveryGreySurvivesLinearLight) {
  for (int value = 0; value < 256; ++value) {
    const auto v = static_cast<uint8_t>(value);
    EXPECT_EQ(toSrgb(toLinear({v, v, v, 255})), (Rgba{v, v, v, 255}));
  }
}

// Black and white make the grey that sends half the light, not the one in the middle of the numbers.
TEST(TileImage, MeansAreOfLight) {
  const LinearTexel white = toLinear({255, 255, 255, 255}), black = toLinear({0, 0, 0, 255});
  EXPECT_EQ(toSrgb(meanOf(white, black, black, white)).green, 188);
}

TEST(TileImage, MeansLeaveOutWhatNoPictureCovers) {
  const LinearTexel red = toLinear({200, 10, 30, 255}), none = toLinear({255, 255, 255, 0});
  EXPECT_EQ(none, LinearTexel{});
  const LinearTexel mean = meanOf(red, none, none, none);
  EXPECT_EQ(toSrgb(mean), (Rgba{200, 10, 30, 255}));
  EXPECT_EQ(mean.coverage, 16384);
  EXPECT_EQ(meanOf(none, none, none, none), LinearTexel{});
}

TEST(TileImage, FillsWhatIsNotCoveredAndNothingElse) {
  Rng rng(test::randomSeed());
  const auto texels = tileOf([&](uint32_t x, uint32_t) {
    return x < 100 ? Rgba{static_cast<uint8_t>(90 + rng.below(20)), 50, 60, 255} : Rgba{7, 7, 7, 0};
  });
  const std::vector<Rgb> colours = filled(texels);
  for (size_t i = 0; i < texels.size(); ++i) {
    if (texels[i].alpha)
      EXPECT_EQ(colours[i], (Rgb{texels[i].red, texels[i].green, texels[i].blue}));
    else
      EXPECT_TRUE(colours[i][0] >= 88 && colours[i][0] <= 112 && colours[i][1] == 50 && colours[i][2] == 60);
  }
  EXPECT_EQ(filled(std::vector<Rgba>(texels.size()))[5], (Rgb{128, 128, 128}));
}

TEST(TileImage, DetailIsWhatTheParentDoesNotShow) {
  const auto flat = tileOf([](uint32_t, uint32_t) { return Rgba{100, 150, 90, 255}; });
  EXPECT_LT(detailOf(flat, filled(flat)), 0.001);
  const auto board = tileOf([](uint32_t x, uint32_t y) {
    return (x + y) % 2 ? Rgba{255, 255, 255, 255} : Rgba{0, 0, 0, 255};
  });
  EXPECT_GT(detailOf(board, filled(board)), 0.4);
  const auto smooth = hills();
  EXPECT_LT(detailOf(smooth, filled(smooth)), kMinDetail);
  const std::vector<Rgba> none(flat.size());
  EXPECT_EQ(detailOf(none, filled(none)), 0);
}

TEST(Webp, GivesBackATileNearlyAsItWas) {
  const std::vector<Rgb> before = filled(hills());
  std::vector<Rgb> after(before.size());
  size_t last = 0;
  for (const auto& [quality, min_db] : {std::pair(30, 30.0), std::pair(75, 34.0), std::pair(100, 40.0)}) {
    const auto bytes = encodeTile(before, quality);
    ASSERT_TRUE(bytes.ok());
    ASSERT_TRUE(decodeTile(*bytes, after).ok());
    EXPECT_GT(psnr(before, after), min_db) << quality;
    EXPECT_GT(bytes->size(), last);
    last = bytes->size();
  }
}

TEST(Webp, DamagedTilesAreRefused) {
  std::vector<Rgb> pixels(size_t{kSide} * kSide);
  const Bytes sound = *encodeTile(filled(hills()), 75);
  EXPECT_FALSE(decodeTile(ByteSpan(), pixels).ok());
  EXPECT_FALSE(decodeTile(ByteSpan(sound).first(20), pixels).ok());
  Bytes changed = sound;
  changed[27] ^= 1;  // the width
  EXPECT_FALSE(decodeTile(changed, pixels).ok());
}

}  // namespace
}  // namespace foreland::terrain
