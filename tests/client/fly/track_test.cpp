#include "client/fly/track.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "base/rng.h"
#include "tests/support/data.h"

namespace foreland::client {
namespace {

constexpr double kDeg = 0.017453292519943295;

// A B record at a time of day, 46 degrees 30 minutes north, 7 degrees 15 minutes east.
std::string fixAt(const std::string& hhmmss, const std::string& gps_m = "02000") {
  return "B" + hhmmss + "4630000N00715000EA01900" + gps_m + "\r\n";
}

void expectLawful(const Track& track) {
  ASSERT_GE(track.fixes.size(), 2u);
  EXPECT_EQ(track.fixes[0].time_s, 0);
  for (size_t i = 1; i < track.fixes.size(); ++i) ASSERT_GT(track.fixes[i].time_s, track.fixes[i - 1].time_s) << i;
}

bool mentions(const Track& track, const std::string& text) {
  return std::ranges::any_of(track.notes, [&](const std::string& n) { return n.find(text) != std::string::npos; });
}

TEST(Igc, ReadsPlaceTimeAndSatelliteHeight) {
  const auto track = parseIgc("AXXX\r\nHFDTE250819\r\n" + fixAt("080000") + fixAt("080010", "02050"), "a.igc");
  ASSERT_TRUE(track.ok());
  expectLawful(*track);
  EXPECT_NEAR(track->fixes[1].latitude_rad, 46.5 * kDeg, 1e-12);
  EXPECT_NEAR(track->fixes[1].longitude_rad, 7.25 * kDeg, 1e-12);
  EXPECT_EQ(track->fixes[1].time_s, 10);
  EXPECT_EQ(track->fixes[1].height_m, 2050);
  EXPECT_EQ(track->skipped, 0u);
}

TEST(Igc, ReadsSouthWestAndNegativeHeights) {
  const auto track = parseIgc("B0800004630000S00715000WA-0012-0034\nB0800014630000S00715000WA-0012-0035\n", "a.igc");
  ASSERT_TRUE(track.ok());
  EXPECT_NEAR(track->fixes[0].latitude_rad, -46.5 * kDeg, 1e-12);
  EXPECT_NEAR(track->fixes[0].longitude_rad, -7.25 * kDeg, 1e-12);
  EXPECT_EQ(track->fixes[1].height_m, -35);
}

TEST(Igc, UsesFurtherDigitsOfTheMinute) {
  const auto track = parseIgc(
      "I023636LAD3737LOD\nB0800004630000N00715000EA019000200059\nB0800014630000N00715000EA019000200059\n", "a.igc");
  ASSERT_TRUE(track.ok());
  EXPECT_NEAR(track->fixes[0].latitude_rad, (46.5 + 0.0005 / 60) * kDeg, 1e-13);
  EXPECT_NEAR(track->fixes[0].longitude_rad, (7.25 + 0.0009 / 60) * kDeg, 1e-13);
}

TEST(Igc, GoesOnOverMidnight) {
  const auto track = parseIgc(fixAt("235958") + fixAt("000003") + fixAt("000010"), "a.igc");
  ASSERT_TRUE(track.ok());
  expectLawful(*track);
  EXPECT_EQ(track->fixes.size(), 3u);
  EXPECT_EQ(track->fixes[2].time_s, 12);
}

TEST(Igc, DropsRepeatedAndBackwardTimesWithANote) {
  const auto track =
      parseIgc(fixAt("080000") + fixAt("080001") + fixAt("080001") + fixAt("080000") + fixAt("080002"), "a.igc");
  ASSERT_TRUE(track.ok());
  expectLawful(*track);
  EXPECT_EQ(track->fixes.size(), 3u);
  EXPECT_EQ(track->skipped, 2u);
  EXPECT_TRUE(mentions(*track, "repeat an earlier time"));
}

TEST(Igc, FallsBackToPressureHeights) {
  const auto track = parseIgc(fixAt("080000", "00000") + fixAt("080001", "00000"), "a.igc");
  ASSERT_TRUE(track.ok());
  EXPECT_EQ(track->fixes[0].height_m, 1900);
  EXPECT_TRUE(mentions(*track, "pressure heights"));
}

TEST(Igc, SkipsBadLinesNamingThem) {
  const auto track =
      parseIgc("A\n" + fixAt("080000") + "B08000\nB0800994630000N00715000EA0190002000\n" + fixAt("080002"), "a.igc");
  ASSERT_TRUE(track.ok());
  EXPECT_EQ(track->fixes.size(), 2u);
  EXPECT_EQ(track->skipped, 2u);
  EXPECT_TRUE(mentions(*track, "a.igc:3: "));
  EXPECT_TRUE(mentions(*track, "a.igc:4: "));
}

TEST(Igc, NotesGaps) {
  const auto track = parseIgc(fixAt("080000") + fixAt("081500"), "a.igc");
  ASSERT_TRUE(track.ok());
  EXPECT_TRUE(mentions(*track, "longest 900 s"));
}

const std::string kGpx = R"(<?xml version="1.0"?><gpx><wpt lat="1" lon="1"><ele>1</ele></wpt>
<trk><trkseg><!-- <trkpt lat="9" lon="9"> -->
<trkpt lat="46.5" lon='7.25'><ele> 2000.5 </ele><time>2019-08-25T23:59:59Z</time></trkpt>
<trkpt lon="7.26" lat="46.6"><ele>2001</ele><time>2019-08-26T02:00:01.5+02:00</time></trkpt>
</trkseg></trk></gpx>)";

TEST(Gpx, ReadsPointsAttributesInAnyOrderAndZones) {
  const auto track = parseGpx(kGpx, "a.gpx");
  ASSERT_TRUE(track.ok()) << track.error().message;
  ASSERT_EQ(track->fixes.size(), 2u);
  EXPECT_NEAR(track->fixes[0].latitude_rad, 46.5 * kDeg, 1e-12);
  EXPECT_NEAR(track->fixes[0].longitude_rad, 7.25 * kDeg, 1e-12);
  EXPECT_EQ(track->fixes[0].height_m, 2000.5);
  EXPECT_NEAR(track->fixes[1].time_s, 2.5, 1e-6);
}

TEST(Gpx, TakesRoutePointsWithoutTimesAtAnAssumedSpeed) {
  const auto track = parseGpx("<gpx><rte><rtept lat='0' lon='0'/><rtept lat='0' lon='0.001'/></rte></gpx>", "a.gpx");
  ASSERT_TRUE(track.ok()) << track.error().message;
  EXPECT_NEAR(track->fixes[1].time_s, 11.12, 0.05);
  EXPECT_EQ(track->heights, TrackHeights::kMissing);
  EXPECT_TRUE(mentions(*track, "no times recorded"));
}

TEST(Gpx, SkipsBadPointsNamingTheirLines) {
  const auto track = parseGpx(
      "<gpx><trkpt lat='0' lon='0'/>\n<trkpt lat='x' lon='0'/>\n<trkpt lon='0'/>\n<trkpt lat='91' lon='0'/>\n"
      "<trkpt lat='0' lon='1'><ele>high</ele></trkpt>\n<trkpt lat='0' lon='2'/></gpx>",
      "a.gpx");
  ASSERT_TRUE(track.ok());
  EXPECT_EQ(track->skipped, 4u);
  for (const char* line : {"a.gpx:2: ", "a.gpx:3: ", "a.gpx:4: ", "a.gpx:5: "})
    EXPECT_TRUE(mentions(*track, line)) << line;
}

TEST(Gpx, RefusesMarkupThatIsNotWellFormedNamingTheLine) {
  const auto open = parseGpx("<gpx>\n<trkpt lat='0' lon='0'>\n<trkpt lat='0' lon='1'/>\n</gpx>", "a.gpx");
  ASSERT_FALSE(open.ok());
  EXPECT_NE(open.error().message.find("a.gpx:4: "), std::string::npos) << open.error().message;
  EXPECT_NE(open.error().message.find("tag"), std::string::npos) << open.error().message;
  EXPECT_FALSE(parseGpx("<gpx><trkpt lat='0' lon='0'/><trkpt", "a.gpx").ok());
}

TEST(Gpx, SkipsDatesThatDoNotExistAndKeepsLeapDays) {
  const auto at = [](const std::string& time) { return "<trkpt lat='0' lon='0'><time>" + time + "</time></trkpt>\n"; };
  const auto track = parseGpx("<gpx>" + at("2020-02-29T23:59:58Z") + at("2020-03-01T00:00:00Z") +
                                  at("2021-02-29T00:00:00Z") + at("2021-01-01T00:00:00+24:00") + "</gpx>",
                              "a.gpx");
  ASSERT_TRUE(track.ok()) << track.error().message;
  EXPECT_EQ(track->fixes.size(), 2u);
  EXPECT_EQ(track->fixes[1].time_s, 2);
  EXPECT_TRUE(mentions(*track, "a.gpx:3: time is not a date and time"));
  EXPECT_TRUE(mentions(*track, "a.gpx:4: "));
}

TEST(Gpx, ReadsNamesWithAPrefixAndCharacterReferences) {
  const auto track = parseGpx(
      "<g:gpx xmlns:g='http://www.topografix.com/GPX/1/1'><g:trkpt lat='&#52;6' lon='7'/>"
      "<g:trkpt lat='46' lon='8'/></g:gpx>",
      "a.gpx");
  ASSERT_TRUE(track.ok()) << track.error().message;
  EXPECT_NEAR(track->fixes[0].latitude_rad, 46 * kDeg, 1e-12);
}

TEST(Track, IsRefusedWithoutTwoFixesAndTheMessageNamesTheFile) {
  for (const std::string& text : {std::string(), std::string("hello\nB\n"), fixAt("080000"), std::string("<gpx></gpx>"),
                                  std::string("<gpx><trkpt")}) {
    for (const auto& track : {parseIgc(text, "my.file"), parseGpx(text, "my.file")}) {
      if (track.ok()) continue;
      EXPECT_NE(track.error().message.find("my.file"), std::string::npos);
    }
  }
  EXPECT_FALSE(parseIgc(fixAt("080000"), "my.file").ok());
  EXPECT_FALSE(parseGpx("<gpx></gpx>", "my.file").ok());
}

// Any bytes end in a lawful track or an error.
TEST(Track, SurvivesMutatedFiles) {
  const uint64_t seed = 20191125;
  Rng rng(seed);
  const std::string igc = "I023636LAD3737LOD\n" + fixAt("235958") + fixAt("235959") + fixAt("000001") + fixAt("000002");
  for (int round = 0; round < 20'000; ++round) {
    std::string text = round % 2 == 0 ? igc : kGpx;
    for (uint64_t edits = 1 + rng.below(6); edits > 0 && !text.empty(); --edits) {
      const size_t at = rng.below(text.size());
      if (rng.below(4) == 0)
        text.erase(at, 1 + rng.below(20));
      else
        text[at] = static_cast<char>(rng.below(3) == 0 ? rng.below(256) : text[rng.below(text.size())]);
    }
    const auto track = round % 2 == 0 ? parseIgc(text, "x") : parseGpx(text, "x");
    if (!track.ok()) continue;
    SCOPED_TRACE("seed " + std::to_string(seed) + ", round " + std::to_string(round));
    expectLawful(*track);
    if (HasFatalFailure()) return;
  }
}

TEST(Track, NamesAFileThatIsMissingOrAFolder) {
  EXPECT_EQ(readTrack("/no/such.igc").error().code, ErrorCode::kNotFound);
  EXPECT_NE(readTrack("/").error().message.find("directory"), std::string::npos);
}

TEST(Track, ReadsTheRealParagliderFlight) {
  FORELAND_DATA_OR_SKIP(path, "tracks/valais_flat100_2019-08-25.igc");
  const auto track = readTrack(path);
  ASSERT_TRUE(track.ok()) << track.error().message;
  expectLawful(*track);
  EXPECT_EQ(track->fixes.size(), 12'446u);
  EXPECT_EQ(track->skipped, 0u);
  EXPECT_NEAR(track->seconds(), 12'568, 1);
}

TEST(Track, ReadsTheRealGpx) {
  FORELAND_DATA_OR_SKIP(path, "tracks/tuolumne.gpx");
  const auto track = readTrack(path);
  ASSERT_TRUE(track.ok()) << track.error().message;
  expectLawful(*track);
  EXPECT_GT(track->fixes.size(), 5'000u);
  EXPECT_EQ(track->heights, TrackHeights::kRecorded);
}

TEST(Track, ReadsRealFilesOfEveryKind) {
  for (const char* name : {"chartreuse_pilot1.igc", "chartreuse_pilot2.igc", "chartreuse_pilot3.igc",
                           "chartreuse_pilot4.igc", "example.igc"}) {
    FORELAND_DATA_OR_SKIP(path, std::string("tracks/") + name);
    const auto track = readTrack(path);
    ASSERT_TRUE(track.ok()) << track.error().message;
    expectLawful(*track);
  }
}

TEST(Track, SkipsTheBadLineOfARealFile) {
  FORELAND_DATA_OR_SKIP(path, "tracks/bad-line.igc");
  const auto track = readTrack(path);
  ASSERT_TRUE(track.ok()) << track.error().message;
  expectLawful(*track);
}

}  // namespace
}  // namespace foreland::client
