#include "client/fly/frame_dump.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>

#include "tests/support/hand_mesh.h"

namespace foreland::client {
namespace {

std::string textOf(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class FrameDumpTest : public ::testing::Test {
 protected:
  std::filesystem::path folder_ =
      std::filesystem::path(::testing::TempDir()) / ("frame_dump_" + std::to_string(::getpid()));
  void TearDown() override { std::filesystem::remove_all(folder_); }
};

TEST_F(FrameDumpTest, WritesPositionsInTheSceneFrameAtTheWeight) {
  KeyframeMesh mesh = test::flatMesh(1, 4);
  mesh.origin = {1e6, 2e6, 100};
  mesh.to_positions[3].z = 8;
  const Bytes ply = encodePly(mesh, 0.25);
  const std::string text(ply.begin(), ply.end());
  EXPECT_TRUE(text.starts_with("ply\nformat binary_little_endian 1.0\n"));
  EXPECT_NE(text.find("element vertex 4\nproperty double x\n"), std::string::npos);
  const std::string end = "end_header\n";
  const size_t body = text.find(end) + end.size();
  ASSERT_EQ(text.size(), body + 4 * 24 + 2 * 13);
  double last[3];
  std::memcpy(last, text.data() + body + 3 * 24, sizeof last);
  EXPECT_EQ(last[0], 1e6 + 4);
  EXPECT_EQ(last[1], 2e6 + 4);
  EXPECT_EQ(last[2], 102);
}

TEST_F(FrameDumpTest, WritesALinePerFrameAndLeavesNothingUnfinished) {
  auto dump = FrameDump::create(folder_);
  ASSERT_TRUE(dump.ok()) << dump.error().message;
  const KeyframeMesh mesh = test::flatMesh(1, 4);
  const FrameView view{.mesh = &mesh, .weight = 0.5, .pose = {}, .shown_time = {}, .mesh_version = 1};
  ASSERT_TRUE(dump->write({0, 0, 0}, view, {}).ok());
  ASSERT_TRUE(dump->write({60, 1, 1}, view, {}).ok());
  const std::string lines = textOf(folder_ / "frames.jsonl");
  EXPECT_EQ(std::ranges::count(lines, '\n'), 2);
  EXPECT_NE(lines.find("\"file\":\"frame_000060.ply\",\"frame\":60,\"time_s\":1.000000"), std::string::npos) << lines;
  EXPECT_NE(lines.find("\"viewport_px\":[1920,1080],\"strategy\":\"predict\",\"tolerance_px\":1,\"weight\":0.5"),
            std::string::npos)
      << lines;
  for (const auto& entry : std::filesystem::directory_iterator(folder_))
    EXPECT_NE(entry.path().extension(), ".unfinished");
}

TEST_F(FrameDumpTest, RefusesAFolderThatCannotBe) {
  const auto dump = FrameDump::create("/dev/null/frames");
  ASSERT_FALSE(dump.ok());
  EXPECT_NE(dump.error().message.find("/dev/null/frames"), std::string::npos);
}

}  // namespace
}  // namespace foreland::client
