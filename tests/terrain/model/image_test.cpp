// The images of models: the same picture from each format, and what is damaged is named.
#include "terrain/model/image.h"

#include <gtest/gtest.h>

#include "base/rng.h"
#include "terrain/model/png.h"
#include "tests/support/files.h"
#include "tests/support/images.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

// Smooth, and so kept well by codecs that lose detail.
Image makePicture() {
  Image image{48, 32, {}};
  for (uint32_t y = 0; y < 32; ++y)
    for (uint32_t x = 0; x < 48; ++x)
      image.pixels.push_back({static_cast<uint8_t>(5 * x), static_cast<uint8_t>(255 - 7 * y), 128, 255});
  return image;
}

void expectPicture(const Bytes& bytes, int tolerance) {
  const auto image = decodeImage(bytes, "skin");
  ASSERT_TRUE(image.ok()) << image.error().message;
  const Image expected = makePicture();
  ASSERT_EQ(image->width, expected.width);
  ASSERT_EQ(image->height, expected.height);
  for (size_t i = 0; i < expected.pixels.size(); ++i)
    for (size_t k = 0; k < 4; ++k) ASSERT_NEAR(image->pixels[i][k], expected.pixels[i][k], tolerance);
}

TEST(Image, IsTheSamePictureInEachFormat) {
  expectPicture(encodePng(makePicture()).value(), 0);
  expectPicture(test::toWebp(makePicture()), 0);
  expectPicture(test::toJpeg(makePicture()), 8);
}

TEST(Image, IsReadFromAFileWhateverItsName) {
  const test::TemporaryFolder folder;
  const Bytes bytes = test::toJpeg(makePicture());
  test::spit(folder / "skin.png", {bytes.begin(), bytes.end()});
  const auto image = readImage(folder / "skin.png");
  ASSERT_TRUE(image.ok()) << image.error().message;
  EXPECT_EQ(image->width, 48u);
  EXPECT_NE(readImage(folder / "gone.webp").error().message.find("gone.webp"), std::string::npos);
}

TEST(Image, NamesWhatItCannotRead) {
  const auto words = [](const Bytes& bytes) {
    const auto image = decodeImage(bytes, "skin");
    return image.ok() ? std::string("an image") : image.error().message;
  };
  EXPECT_EQ(words({}), "skin: neither a PNG, nor a JPEG, nor a WebP image; convert it to one of these");
  for (const Bytes& whole :
       {encodePng(makePicture()).value(), test::toWebp(makePicture()), test::toJpeg(makePicture())}) {
    const std::string cut = words({whole.begin(), whole.begin() + 24});
    EXPECT_TRUE(cut.starts_with("skin: not a readable ")) << cut;
  }
}

TEST(Image, DamagedFilesEndInAnImageOrAnError) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  const Bytes files[] = {encodePng(makePicture()).value(), test::toWebp(makePicture()), test::toJpeg(makePicture())};
  for (int i = 0; i < 1500; ++i) {
    Bytes bytes = files[i % 3];
    for (uint64_t changes = 1 + rng.below(4); changes > 0; --changes)
      bytes[rng.below(bytes.size())] = static_cast<uint8_t>(rng.next());
    if (rng.below(4) == 0) bytes.resize(rng.below(bytes.size()));
    const auto image = decodeImage(bytes, "skin");
    if (!image.ok()) continue;
    ASSERT_EQ(image->pixels.size(), uint64_t{image->width} * image->height);
  }
}

}  // namespace
}  // namespace foreland::terrain
