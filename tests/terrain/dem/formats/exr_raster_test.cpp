// OpenEXR height maps as other programs write them: half floats, several channels, a data window that does not begin at
// zero.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/terrain/dem/dem_files.h"

namespace foreland::terrain {
namespace {

using DemExr = DemFiles;

constexpr int kWidth = 4, kHeight = 3;

// Every channel is half; the i-th holds 1000 * i + 100 * row + column.
void writeHalf(const std::filesystem::path& path, const std::vector<std::string>& channels) {
  const Imath::Box2i window({-2, 7}, {-2 + kWidth - 1, 7 + kHeight - 1});
  Imf::Header header(window, window);
  std::vector<std::vector<half>> samples(channels.size(), std::vector<half>(kWidth * kHeight));
  Imf::FrameBuffer buffer;
  for (size_t i = 0; i < channels.size(); ++i) {
    header.channels().insert(channels[i], Imf::Channel(Imf::HALF));
    for (int k = 0; k < kWidth * kHeight; ++k)
      samples[i][static_cast<size_t>(k)] =
          static_cast<float>(1000 * static_cast<int>(i) + 100 * (k / kWidth) + k % kWidth);
    buffer.insert(channels[i], Imf::Slice::Make(Imf::HALF, samples[i].data(), window));
  }
  Imf::OutputFile file(path.c_str(), header);
  file.setFrameBuffer(buffer);
  file.writePixels(kHeight);
}

TEST_F(DemExr, HalfFloatsAreReadWithTheTopRowInTheNorth) {
  writeHalf(folder_ / "half.exr", {"Y"});
  auto source = open(folder_ / "half.exr");
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_EQ(readAll(**source), (std::vector<float>{200, 201, 202, 203, 100, 101, 102, 103, 0, 1, 2, 3}));
}

TEST_F(DemExr, WithoutASpacingItIsOneMetreAndSaid) {
  writeHalf(folder_ / "half.exr", {"Y"});
  auto source = open(folder_ / "half.exr");
  ASSERT_TRUE(source.ok());
  EXPECT_EQ((*source)->info().frame.axis_x_m.x, 1);
  EXPECT_TRUE(hasNote(**source, "--spacing"));
  EXPECT_EQ((*open(folder_ / "half.exr", {.spacing_m = 30}))->info().frame.axis_y_m.y, 30);
}

TEST_F(DemExr, TheChannelIsTheNamedOneOrTheUsualOneOrAsked) {
  writeHalf(folder_ / "several.exr", {"A", "R"});
  auto usual = open(folder_ / "several.exr");
  ASSERT_TRUE(usual.ok());
  EXPECT_EQ(readAll(**usual).front(), 1200);
  auto named = open(folder_ / "several.exr", {.channel = "A"});
  ASSERT_TRUE(named.ok());
  EXPECT_EQ(readAll(**named).front(), 200);
  writeHalf(folder_ / "odd.exr", {"P", "Q"});
  expectRefusal(open(folder_ / "odd.exr"), "odd.exr", "--channel: P, Q");
}

TEST_F(DemExr, AnImageIsNoPartOfAMosaic) {
  writeHalf(folder_ / "a.exr", {"Y"});
  writeHalf(folder_ / "b.exr", {"Y"});
  const auto source = openElevation({folder_ / "a.exr", folder_ / "b.exr"}, {});
  expectRefusal(source, "a.exr", "mosaic");
}

}  // namespace
}  // namespace foreland::terrain
