#include "apps/serve/scene_picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "server/net/http/png.h"
#include "terrain/model/png.h"
#include "tests/support/files.h"
#include "tests/support/scene.h"

namespace foreland::apps {
namespace {

double brightness(const std::array<uint8_t, 3>& pixel) { return pixel[0] + pixel[1] + pixel[2]; }

TEST(ScenePicture, HasNorthAboveAndLightFromTheNorthWest) {
  // A ridge along the diagonal from south-west to north-east, whose north-western side is lit.
  const auto ridge = test::makeScene(129, 129, [](uint32_t x, uint32_t y) {
    return 1000.0 - 10 * std::abs(static_cast<double>(x) - static_cast<double>(y));
  });
  const server::Picture picture = scenePicture(*ridge);
  ASSERT_EQ(picture.width, 129u);
  ASSERT_EQ(picture.height, 129u);
  const auto at = [&](uint32_t east, uint32_t north) { return picture.pixels[(128 - north) * 129 + east]; };
  for (uint32_t i = 30; i < 100; i += 7)
    EXPECT_GT(brightness(at(i - 10, i + 10)), 1.5 * brightness(at(i + 10, i - 10)));
}

TEST(ScenePicture, IsSmallOfLargeScenes) {
  const server::Picture picture = scenePicture(*test::makeScene(1500, 700, 3));
  EXPECT_GE(picture.width, 320u);
  EXPECT_LE(picture.width, 640u);
  EXPECT_NEAR(picture.width / 1500.0, picture.height / 700.0, 0.01);
}

// By the reader of pictures that the program has for models.
TEST(ScenePicture, IsWrittenAsPng) {
  const server::Picture picture = scenePicture(*test::makeScene(65, 33, 5));
  const test::TemporaryFolder folder;
  std::ofstream(folder / "picture.png", std::ios::binary) << server::encodePng(picture);
  const auto read = terrain::readPng(folder / "picture.png");
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->width, picture.width);
  ASSERT_EQ(read->height, picture.height);
  for (size_t i = 0; i < picture.pixels.size(); ++i) {
    const auto& [red, green, blue] = picture.pixels[i];
    EXPECT_EQ(read->pixels[i], (terrain::Colour{red, green, blue, 255})) << i;
  }
}

}  // namespace
}  // namespace foreland::apps
