#include "client/fly/tracks/track.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "base/rng.h"
#include "tests/support/data.h"
#include "tests/support/files.h"

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
      "<gpx><trkpt lat='1' lon='0'/>\n<trkpt lat='x' lon='0'/>\n<trkpt lon='0'/>\n<trkpt lat='91' lon='0'/>\n"
      "<trkpt lat='1' lon='1'><ele>high</ele></trkpt>\n<trkpt lat='1' lon='2'/></gpx>",
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
  const auto at = [](const std::string& time) { return "<trkpt lat='1' lon='0'><time>" + time + "</time></trkpt>\n"; };
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

TEST(Gpx, TakesEmptyElementsAsAbsent) {
  const auto track = parseGpx(
      "<gpx><trkpt lat='46' lon='7'><ele></ele><time/></trkpt>"
      "<trkpt lat='46' lon='7.1'><ele> \n </ele><time></time></trkpt></gpx>",
      "a.gpx");
  ASSERT_TRUE(track.ok()) << track.error().message;
  EXPECT_EQ(track->skipped, 0u);
  EXPECT_EQ(track->heights, TrackHeights::kMissing);
  EXPECT_TRUE(mentions(*track, "no times recorded"));
}

TEST(Gpx, FliesWaypointsIfThereIsNothingElse) {
  const std::string points = "<wpt lat='46' lon='7'><ele>900</ele></wpt><wpt lat='46.001' lon='7'><ele>910</ele></wpt>";
  const auto track = parseGpx("<gpx>" + points + "</gpx>", "a.gpx");
  ASSERT_TRUE(track.ok()) << track.error().message;
  EXPECT_EQ(track->fixes[1].height_m, 910);
  EXPECT_TRUE(mentions(*track, "its 2 waypoints are flown"));
  const auto route = parseGpx(
      "<gpx>" + points + "<rte><rtept lat='1' lon='2'/><rtept lat='1' lon='3'/><rtept lat='1' lon='4'/></rte></gpx>",
      "a.gpx");
  ASSERT_TRUE(route.ok()) << route.error().message;
  EXPECT_EQ(route->fixes.size(), 3u);
  EXPECT_FALSE(mentions(*route, "waypoints"));
}

TEST(Gpx, NamesTheRootOfOtherMarkup) {
  const auto html = parseGpx("<html><body/></html>", "a.gpx");
  ASSERT_FALSE(html.ok());
  EXPECT_NE(html.error().message.find("<html>"), std::string::npos) << html.error().message;
}

// A point north by `arc_s` seconds of arc, about 30.9 m each, at so many seconds.
std::string gpxPoint(int arc_s, int time_s) {
  char text[160];
  std::snprintf(text, sizeof(text),
                "<trkpt lat='%.9f' lon='7'><ele>%d</ele><time>2024-05-01T10:%02d:%02dZ</time></trkpt>\n",
                46 + arc_s / 3600.0, 1000 + arc_s, time_s / 60, time_s % 60);
  return text;
}

TEST(Track, AClockThatStandsOrGoesBackIsReplacedByAConstantSpeed) {
  constexpr double kStep_s = 3.0888;  // of a second of arc at 10 m/s
  for (const int direction : {0, -2}) {
    std::string points;
    for (int i = 0; i < 50; ++i) points += gpxPoint(i, 600 + direction * i);
    const auto track = parseGpx("<gpx>" + points + "</gpx>", "a.gpx");
    ASSERT_TRUE(track.ok()) << track.error().message;
    expectLawful(*track);
    EXPECT_EQ(track->fixes.size(), 50u);
    EXPECT_NEAR(track->seconds(), 49 * kStep_s, 0.5);
    EXPECT_EQ(track->skipped, 0u);
    EXPECT_TRUE(mentions(*track, "at 49 fixes; flown at 10 m/s there (--speed"));
  }
  // Set back by ten minutes in the middle: one step is assumed, the times behind it are as recorded.
  std::string points;
  for (int i = 0; i < 50; ++i) points += gpxPoint(i, (i < 25 ? 700 : 100) + 2 * i);
  const auto track = parseGpx("<gpx>" + points + "</gpx>", "a.gpx");
  ASSERT_TRUE(track.ok()) << track.error().message;
  expectLawful(*track);
  EXPECT_EQ(track->fixes.size(), 50u);
  EXPECT_NEAR(track->seconds(), 48 * 2 + kStep_s, 0.1);
  EXPECT_TRUE(mentions(*track, "at 1 fixes"));
}

// What has no time between fixes that have one keeps their speed; before, behind and in between without end it is 10
// m/s.
TEST(Track, FixesWithoutTimesAreFlownAtAConstantSpeed) {
  constexpr double kStep_s = 3.0888;  // of a second of arc at 10 m/s
  const auto untimed = [](int arc_s) {
    const std::string whole = gpxPoint(arc_s, 0);
    return whole.substr(0, whole.find("<time>")) + "</trkpt>\n";
  };
  const auto seconds = [](const std::string& points) {
    const auto track = parseGpx("<gpx>" + points + "</gpx>", "a.gpx");
    EXPECT_TRUE(track.ok()) << track.error().message;
    EXPECT_TRUE(mentions(*track, "fixes have no time; flown at a constant speed there (--speed"));
    expectLawful(*track);
    EXPECT_EQ(track->skipped, 0u);
    std::vector<double> times;
    for (const Fix& fix : track->fixes) times.push_back(fix.time_s);
    return times;
  };
  const auto between = seconds(gpxPoint(0, 0) + untimed(1) + untimed(3) + gpxPoint(4, 40) + gpxPoint(5, 50));
  ASSERT_EQ(between.size(), 5u);
  EXPECT_NEAR(between[1], 10, 1e-3);
  EXPECT_NEAR(between[2], 30, 1e-3);
  EXPECT_EQ(between[3], 40);
  const auto around = seconds(untimed(0) + untimed(1) + gpxPoint(3, 20) + gpxPoint(4, 30) + untimed(6));
  ASSERT_EQ(around.size(), 5u);
  EXPECT_NEAR(around[1], kStep_s, 1e-2);
  EXPECT_NEAR(around[2], 3 * kStep_s, 1e-2);
  EXPECT_NEAR(around[3], 3 * kStep_s + 10, 1e-2);
  EXPECT_NEAR(around[4], 5 * kStep_s + 10, 1e-2);
  // A line of 3 km between two that follow each other within a second: the clock is set anew behind it.
  const auto line =
      seconds(gpxPoint(0, 0) + gpxPoint(1, 10) + untimed(2) + untimed(101) + gpxPoint(102, 11) + gpxPoint(103, 21));
  ASSERT_EQ(line.size(), 6u);
  EXPECT_NEAR(line[4], 10 + 101 * kStep_s, 0.1);
  EXPECT_NEAR(line[5], 20 + 101 * kStep_s, 0.1);
}

TEST(Gpx, LeavesOutPointsMarkedAsHavingNoFix) {
  const auto at = [](const char* latitude, const char* fix) {
    return std::string("<trkpt lat='") + latitude + "' lon='7'><fix>" + fix + "</fix></trkpt>\n";
  };
  const auto track = parseGpx("<gpx>" + at("46", "3d") + at("20", " none ") + at("46.1", "2d") + "</gpx>", "a.gpx");
  ASSERT_TRUE(track.ok()) << track.error().message;
  EXPECT_EQ(track->fixes.size(), 2u);
  EXPECT_EQ(track->skipped, 1u);
  EXPECT_TRUE(mentions(*track, "a.gpx:2: marked as having no fix (<fix>none)"));
}

TEST(Track, FixesWithoutAPositionAreLeftOutByLine) {
  const std::string nowhere = "B0800010000000N00000000EA0190002000\n";
  const auto igc = parseIgc("A\n" + nowhere + fixAt("080002") + nowhere + fixAt("080004"), "a.igc");
  ASSERT_TRUE(igc.ok()) << igc.error().message;
  EXPECT_EQ(igc->fixes.size(), 2u);
  EXPECT_EQ(igc->seconds(), 2);
  EXPECT_EQ(igc->skipped, 2u);
  EXPECT_TRUE(mentions(*igc, "a.igc:2: no position"));
  EXPECT_TRUE(mentions(*igc, "a.igc:4: no position"));
  const auto gpx = parseGpx(
      "<gpx><trkpt lat='0.0' lon='0'/>\n<trkpt lat='46' lon='7'/>\n<trkpt lat='46' lon='7.1'/></gpx>", "a.gpx");
  ASSERT_TRUE(gpx.ok()) << gpx.error().message;
  EXPECT_EQ(gpx->fixes.size(), 2u);
  EXPECT_TRUE(mentions(*gpx, "a.gpx:1: no position"));
  const auto off_ghana = parseGpx("<gpx><trkpt lat='0' lon='0'/><trkpt lat='0' lon='0.1'/></gpx>", "a.gpx");
  ASSERT_TRUE(off_ghana.ok()) << "a track that passes there keeps its fix";
  EXPECT_EQ(off_ghana->fixes.size(), 2u);
}

TEST(Igc, LeavesOutInvalidFixesByLine) {
  std::string invalid = fixAt("080001");
  invalid[24] = 'V';
  const auto track = parseIgc(invalid + fixAt("080002") + invalid + fixAt("080005"), "a.igc");
  ASSERT_TRUE(track.ok()) << track.error().message;
  EXPECT_EQ(track->fixes.size(), 2u);
  EXPECT_EQ(track->seconds(), 3);
  EXPECT_TRUE(mentions(*track, "a.igc:1: marked as invalid (V)"));
  EXPECT_TRUE(mentions(*track, "a.igc:3: marked as invalid (V)"));
  std::string later = fixAt("080003");
  later[24] = 'V';
  const auto all = parseIgc(invalid + later, "a.igc");
  ASSERT_TRUE(all.ok()) << "a recorder without heights of satellites marks every fix";
  EXPECT_TRUE(mentions(*all, "all fixes are marked as invalid"));
}

TEST(Igc, ReadsAnyLineEnds) {
  std::string text = "A\r\n" + fixAt("080000") + fixAt("080010");
  std::erase(text, '\n');
  const auto track = parseIgc(text, "a.igc");
  ASSERT_TRUE(track.ok()) << track.error().message;
  EXPECT_EQ(track->fixes.size(), 2u);
}

TEST(Kml, ReadsLinesAndTracks) {
  const auto line = parseKml(
      "<kml xmlns='http://www.opengis.net/kml/2.2'><Document><Placemark><Point><coordinates>1,1,1</coordinates></Point>"
      "</Placemark><Placemark><LineString><altitudeMode>absolute</altitudeMode><coordinates>\n7.25,46.5,2000\n"
      "7.25,x\n 7.25,46.501,2010.5 </coordinates></LineString></Placemark></Document></kml>",
      "a.kml");
  ASSERT_TRUE(line.ok()) << line.error().message;
  ASSERT_EQ(line->fixes.size(), 2u);
  EXPECT_NEAR(line->fixes[1].latitude_rad, 46.501 * kDeg, 1e-12);
  EXPECT_NEAR(line->fixes[1].longitude_rad, 7.25 * kDeg, 1e-12);
  EXPECT_EQ(line->fixes[1].height_m, 2010.5);
  EXPECT_NEAR(line->seconds(), 11.12, 0.05);
  EXPECT_TRUE(mentions(*line, "a.kml:3: "));

  const auto track = parseKml(
      "<kml:kml xmlns:kml='k' xmlns:gx='g'><gx:MultiTrack><gx:Track><kml:when>2024-05-01T10:00:00Z</kml:when>"
      "<kml:when>2024-05-01T10:00:07Z</kml:when><gx:coord>7.25 46.5 2000</gx:coord><gx:coord>7.26 46.5 2005</gx:coord>"
      "</gx:Track></gx:MultiTrack></kml:kml>",
      "a.kml");
  ASSERT_TRUE(track.ok()) << track.error().message;
  EXPECT_EQ(track->seconds(), 7);
  EXPECT_EQ(track->fixes[1].height_m, 2005);
  EXPECT_EQ(track->notes, std::vector<std::string>());
}

// However places are spaced, they are the same.
TEST(Kml, ReadsPlacesAsPeopleSpaceThem) {
  for (const char* places :
       {"7.25,46.5,2000 7.26,46.5,2010", "\n\t7.25,46.5,2000\n\t7.26,46.5,2010\n", "7.25, 46.5, 2000 7.26, 46.5, 2010",
        "7.25 , 46.5 , 2000\r\n7.26 , 46.5 , 2010", "7.25 ,46.5 ,2000\n\n 7.26 ,46.5 ,2010",
        "7.25,\n46.5,\n2000\n7.26,46.5,2010", "7.25,46.5, 2000\n7.26,46.5, 2010", "7.25,46.5,2000, 7.26,46.5,2010,",
        "7.25,46.5,2000<!-- the top --> 7.26,46.5,2010", "<![CDATA[7.25,46.5,2000 7.26,46.5,2010]]>",
        "+7.25,46.50,2.0e3\t7.26,46.5,2010"}) {
    const auto track = parseKml(std::string("<kml><LineString><altitudeMode>absolute</altitudeMode><coordinates>") +
                                    places + "</coordinates></LineString></kml>",
                                "a.kml");
    ASSERT_TRUE(track.ok()) << places << ": " << track.error().message;
    ASSERT_EQ(track->fixes.size(), 2u) << places;
    EXPECT_EQ(track->skipped, 0u) << places;
    for (const size_t i : {0, 1}) {
      EXPECT_NEAR(track->fixes[i].longitude_rad, (i == 0 ? 7.25 : 7.26) * kDeg, 1e-12) << places;
      EXPECT_NEAR(track->fixes[i].latitude_rad, 46.5 * kDeg, 1e-12) << places;
      EXPECT_EQ(track->fixes[i].height_m, i == 0 ? 2000 : 2010) << places;
    }
  }
  const auto wrong =
      parseKml("<kml><LineString><coordinates>\n7, 46\n7, x\n7, 46.1</coordinates></LineString></kml>", "a.kml");
  ASSERT_TRUE(wrong.ok()) << wrong.error().message;
  EXPECT_EQ(wrong->fixes.size(), 2u);
  EXPECT_TRUE(mentions(*wrong, "a.kml:3: "));
}

TEST(Kml, HeightsAreThoseOfTheAltitudeMode) {
  const auto withMode = [](const std::string& mode, const std::string& heights) {
    return parseKml("<kml><LineString>" + mode + "<coordinates>7,46," + heights + " 7,46.1," + heights +
                        "</coordinates></LineString></kml>",
                    "a.kml");
  };
  EXPECT_EQ(withMode("", "0")->heights, TrackHeights::kMissing);
  EXPECT_EQ(withMode("", "900")->heights, TrackHeights::kRecorded);
  EXPECT_EQ(withMode("<altitudeMode>clampToGround</altitudeMode>", "900")->heights, TrackHeights::kMissing);
  const auto above = withMode("<altitudeMode>relativeToGround</altitudeMode>", "50");
  EXPECT_EQ(above->heights, TrackHeights::kMissing);
  EXPECT_TRUE(mentions(*above, "--agl"));
}

TEST(Kml, FliesPointsIfThereIsNoLine) {
  const auto at = [](const char* second, const char* place) {
    return std::string("<Placemark><TimeStamp><when>2024-05-01T10:00:") + second +
           "Z</when></TimeStamp><Point><coordinates>" + place + "</coordinates></Point></Placemark>";
  };
  const auto track = parseKml("<kml>" + at("00", "7,46") + at("09", "7,46.1") + "</kml>", "a.kml");
  ASSERT_TRUE(track.ok()) << track.error().message;
  EXPECT_EQ(track->seconds(), 9);
  EXPECT_TRUE(mentions(*track, "its 2 points are flown"));
}

TEST(GeoJson, ReadsLinesWithAndWithoutTimes) {
  const auto bare = parseGeoJson(
      R"({"type":"LineString","coordinates":[[7.25,46.5,2000],["x",46],[7.25,46.501,2010]]})", "a.geojson");
  ASSERT_TRUE(bare.ok()) << bare.error().message;
  ASSERT_EQ(bare->fixes.size(), 2u);
  EXPECT_NEAR(bare->fixes[1].latitude_rad, 46.501 * kDeg, 1e-12);
  EXPECT_NEAR(bare->fixes[1].longitude_rad, 7.25 * kDeg, 1e-12);
  EXPECT_EQ(bare->fixes[1].height_m, 2010);
  EXPECT_TRUE(mentions(*bare, "a.geojson: point 2: "));

  const auto timed = parseGeoJson(R"({"type":"FeatureCollection","features":[
      {"type":"Feature","properties":null,"geometry":{"type":"Point","coordinates":[1,1]}},
      {"type":"Feature","properties":{"coordTimes":[["2024-05-01T10:00:00Z","2024-05-01T10:00:05Z"],["2024-05-01T10:01:00Z"]]},
       "geometry":{"type":"MultiLineString","coordinates":[[[7,46],[7,46.1]],[[7,46.2]]]}}]})",
                                  "a.geojson");
  ASSERT_TRUE(timed.ok()) << timed.error().message;
  EXPECT_EQ(timed->seconds(), 60);
  EXPECT_TRUE(mentions(*timed, "2 lines flown one after another"));

  const auto newer = parseGeoJson(R"({"type":"Feature","properties":{"coordinateProperties":{"times":
      ["2024-05-01T10:00:00Z","2024-05-01T10:00:05Z"]}},
      "geometry":{"type":"LineString","coordinates":[[7,46],[7,46.1]]}})",
                                  "a.geojson");
  ASSERT_TRUE(newer.ok()) << newer.error().message;
  EXPECT_EQ(newer->seconds(), 5);
  const auto points = parseGeoJson(R"({"type":"GeometryCollection","geometries":[{"type":"Point","coordinates":[7,46]},
      {"type":"MultiPoint","coordinates":[[7,46.1],[7,46.2]]}]})",
                                   "a.geojson");
  ASSERT_TRUE(points.ok()) << points.error().message;
  EXPECT_EQ(points->fixes.size(), 3u);
  EXPECT_TRUE(mentions(*points, "its 3 points are flown"));
  for (const char* wrong : {"{", "{}", R"({"type":"Feature"})", R"({"type":"LineString","coordinates":7})"}) {
    const auto track = parseGeoJson(wrong, "a.geojson");
    ASSERT_FALSE(track.ok()) << wrong;
    EXPECT_NE(track.error().message.find("a.geojson"), std::string::npos);
  }
}

TEST(GeoJson, ReadsSequences) {
  const auto feature = [](const char* latitude, const char* second) {
    return std::string(R"({"type":"Feature","properties":{"coordTimes":["2024-05-01T10:00:)") + second + R"(Z"]},)" +
           R"("geometry":{"type":"LineString","coordinates":[[7,)" + latitude + ",900]]}}";
  };
  const std::string a = feature("46", "00"), b = feature("46.1", "09");
  for (const std::string& text :
       {a + "\n" + b, a + "\r\n\n" + b + "\n", "\x1e" + a + "\n\x1e" + b + "\n", "\n\x1e" + a + "\x1e\x1e\n" + b}) {
    const auto track = parseGeoJson(text, "a.geojsonl");
    ASSERT_TRUE(track.ok()) << track.error().message;
    EXPECT_EQ(track->fixes.size(), 2u);
    EXPECT_EQ(track->seconds(), 9);
    EXPECT_EQ(track->notes.size(), 1u) << "the number of lines";
  }
  const auto cut = parseGeoJson("\x1e" + a + "\n\x1e" + b + "\n\x1e" + a.substr(0, 40), "a.geojsonl");
  ASSERT_TRUE(cut.ok()) << cut.error().message;
  EXPECT_TRUE(mentions(*cut, "1 objects of the sequence are broken"));
  for (const std::string& text : {"\x1e" + a.substr(0, 40), a.substr(0, 40) + "\n" + b, std::string("\x1e\n\x1e")})
    EXPECT_FALSE(parseGeoJson(text, "a.geojsonl").ok()) << text;
}

std::string asUtf16(const std::string& text, bool is_big, bool has_mark) {
  std::string out;
  const auto put = [&](uint32_t unit) {
    const char high = static_cast<char>(unit >> 8), low = static_cast<char>(unit & 0xff);
    out += is_big ? high : low;
    out += is_big ? low : high;
  };
  if (has_mark) put(0xfeff);
  for (const char c : text) put(static_cast<uint8_t>(c));
  return out;
}

std::string asGzip(const std::string& text) {
  std::string out(text.size() + 1000, '\0');
  z_stream stream{};
  EXPECT_EQ(deflateInit2(&stream, 9, Z_DEFLATED, 16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY), Z_OK);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data()), stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

TEST(Track, IsReadInAnyEncodingAndPackedByGzip) {
  const test::TemporaryFolder folder;
  const auto read = [&](const std::string& bytes) {
    std::ofstream(folder / "track", std::ios::binary) << bytes;
    return readTrack(folder / "track");
  };
  const std::string igc = "A\n" + fixAt("080000") + fixAt("080010"),
                    json = R"({"type":"LineString","coordinates":[[7,46],[7,46.1]]})",
                    kml =
                        "<?xml version='1.0' encoding='UTF-16'?><!-- <gpx> --><kml><LineString><coordinates>7,46 "
                        "7,46.1</coordinates></LineString></kml>";
  const std::string sequence = "\x1e" + json + "\n";
  for (const std::string& text : {igc, kGpx, json, sequence, kml}) {
    SCOPED_TRACE(text.substr(0, 20));
    for (const std::string& bytes :
         {text, "\xef\xbb\xbf" + text, asUtf16(text, false, true), asUtf16(text, true, true),
          asUtf16(text, false, false), asUtf16(text, true, false), asGzip(text), asGzip(asUtf16(text, true, true)),
          asGzip(text.substr(0, 30)) + asGzip(text.substr(30)) + std::string(4, '\0')}) {
      const auto track = read(bytes);
      ASSERT_TRUE(track.ok()) << track.error().message;
      EXPECT_EQ(track->fixes.size(), 2u);
    }
  }
  const auto words = [&](const std::string& bytes) {
    const auto track = read(bytes);
    return track.ok() ? std::string("a track") : track.error().message;
  };
  const std::string packed = asGzip(igc);
  EXPECT_NE(words(packed.substr(0, packed.size() - 9)).find("damaged or cut short"), std::string::npos);
  EXPECT_NE(words("PK\x03\x04 and so on").find("ZIP archive"), std::string::npos);
  EXPECT_NE(words("hello").find("expected IGC, GPX, KML, GeoJSON"), std::string::npos);
  EXPECT_NE(words(asGzip(std::string((256u << 20) + 1, ' '))).find("larger than 256 MiB"), std::string::npos);
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
  const std::string kml =
      "<kml><gx:Track><when>2024-05-01T10:00:00Z</when><gx:coord>7 46 1</gx:coord><gx:coord>7 47 1"
      "</gx:coord></gx:Track><LineString><coordinates>7,46,1 7,47,2</coordinates></LineString></kml>";
  const std::string json = R"({"type":"Feature","properties":{"coordTimes":["2024-05-01T10:00:00Z",5]},
      "geometry":{"type":"LineString","coordinates":[[7,46,1],[7,46.1]]}})";
  for (int round = 0; round < 20'000; ++round) {
    std::string text = round % 4 == 0 ? igc : round % 4 == 1 ? kGpx : round % 4 == 2 ? kml : json;
    for (uint64_t edits = 1 + rng.below(6); edits > 0 && !text.empty(); --edits) {
      const size_t at = rng.below(text.size());
      if (rng.below(4) == 0)
        text.erase(at, 1 + rng.below(20));
      else
        text[at] = static_cast<char>(rng.below(3) == 0 ? rng.below(256) : text[rng.below(text.size())]);
    }
    const auto track = round % 4 == 0   ? parseIgc(text, "x")
                       : round % 4 == 1 ? parseGpx(text, "x")
                       : round % 4 == 2 ? parseKml(text, "x")
                                        : parseGeoJson(text, "x");
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
