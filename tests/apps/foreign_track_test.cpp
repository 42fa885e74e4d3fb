// A recorded flight that a confined child reads is the one that the reader reads, or an Error with its words.
#include "apps/options/foreign_track.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

#include "base/rng.h"
#include "tests/support/files.h"
#include "tests/support/seed.h"

namespace foreland::apps {
namespace {

using client::Track;

const std::string kGpx =
    "<gpx><trkpt lat='46' lon='7'><ele>900</ele></trkpt><trkpt lat='46.1' lon='7'/><trkpt lat='x' lon='7'/></gpx>";
const std::string kCameras = "F 0 1 0 0 0 1 0 0 0 1 0 0 5 60\nF 0 1 0 0 0 1 0 0 0 1 1 0 5 60\n";

void expectSame(const Result<Track>& a, const Result<Track>& b) {
  ASSERT_EQ(a.ok(), b.ok());
  if (!a.ok()) {
    EXPECT_EQ(a.error().message, b.error().message);
    EXPECT_EQ(a.error().code, b.error().code);
    return;
  }
  EXPECT_EQ(a->notes, b->notes);
  EXPECT_EQ(a->skipped, b->skipped);
  EXPECT_EQ(a->heights, b->heights);
  ASSERT_EQ(a->fixes.size(), b->fixes.size());
  for (size_t i = 0; i < a->fixes.size(); ++i) {
    EXPECT_EQ(a->fixes[i].time_s, b->fixes[i].time_s);
    EXPECT_EQ(a->fixes[i].latitude_rad, b->fixes[i].latitude_rad);
    EXPECT_EQ(a->fixes[i].longitude_rad, b->fixes[i].longitude_rad);
    EXPECT_EQ(a->fixes[i].height_m, b->fixes[i].height_m);
  }
  ASSERT_EQ(a->cameras.size(), b->cameras.size());
  for (size_t i = 0; i < a->cameras.size(); ++i) EXPECT_EQ(a->cameras[i].eye, b->cameras[i].eye);
}

TEST(ForeignTrack, IsWhatTheReaderReads) {
  const test::TemporaryFolder folder;
  for (const std::string& text : {kGpx, kCameras, std::string("hello"), std::string("<gpx>"), std::string()}) {
    std::ofstream(folder / "track") << text;
    expectSame(readForeignTrack(folder / "track"), client::readTrack(folder / "track"));
  }
  expectSame(readForeignTrack(folder / "gone"), client::readTrack(folder / "gone"));
  std::filesystem::create_symlink(folder / "track", folder / "link");
  std::ofstream(folder / "track") << kGpx;
  expectSame(readForeignTrack(folder / "link"), client::readTrack(folder / "link"));
}

// A reader that is led astray has no socket to tell anybody.
TEST(ForeignTrack, IsReadByAProcessWithoutSockets) {
  const TrackReader astray = [](const std::filesystem::path& path) -> Result<Track> {
    const int connection = socket(AF_INET, SOCK_STREAM, 0);
    return Error{ErrorCode::kIo, path.string() + (connection >= 0 ? ": connected" : ": cannot connect")};
  };
  const auto track = readForeignTrack("some.gpx", astray);
  ASSERT_FALSE(track.ok());
  EXPECT_EQ(track.error().message, "some.gpx: cannot connect");
  const auto dead = readForeignTrack("some.gpx", [](const std::filesystem::path&) -> Result<Track> { _exit(1); });
  ASSERT_FALSE(dead.ok());
  EXPECT_EQ(dead.error().message, "some.gpx: its reader failed");
}

// Whatever a child answers ends in a track that keeps the reader's laws, or in an Error.
TEST(ForeignTrack, AnyAnswerIsALawfulTrackOrAnError) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  const Bytes answers[] = {encodeTrack(client::parseGpx(kGpx, "a")),
                           encodeTrack(client::parseCameraFrames(kCameras, "a")),
                           encodeTrack(Error{ErrorCode::kIo, "a: gone"})};
  int refused = 0;
  for (int round = 0; round < 30'000; ++round) {
    Bytes bytes = answers[round % 3];
    for (uint64_t edits = 1 + rng.below(3); edits > 0; --edits)
      bytes[rng.below(bytes.size())] = static_cast<uint8_t>(rng.next());
    if (rng.below(8) == 0) bytes.resize(rng.below(bytes.size()));
    const auto track = decodeTrack(bytes, "a");
    refused += !track.ok();
    if (!track.ok()) continue;
    ASSERT_NE(track->fixes.empty(), track->cameras.empty());
    for (size_t i = 1; i < track->fixes.size(); ++i) ASSERT_GT(track->fixes[i].time_s, track->fixes[i - 1].time_s);
    for (const client::Fix& fix : track->fixes) ASSERT_TRUE(std::isfinite(fix.height_m));
    for (const client::CameraFrame& frame : track->cameras) ASSERT_TRUE(std::isfinite(frame.eye.x));
  }
  EXPECT_GT(refused, 1000);
  EXPECT_LT(refused, 30'000);
}

}  // namespace
}  // namespace foreland::apps
