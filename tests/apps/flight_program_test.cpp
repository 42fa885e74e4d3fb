// The whole of it, as a newcomer runs it: synth, build, verify, serve, fly, measured against the truth. And what
// `foreland fly` says about bad input.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/apps/expect_refusal.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

// What a replay reports is what the flight reported. A recording whose last messages are lost ends early.
void expectSameReplay(const std::string& recording, const std::string& scene, const nlohmann::json& report) {
  const ProgramResult replayed =
      runProgram("replay", {recording, "--truth", scene, "--json"}, {.streams = Streams::kOutputOnly});
  ASSERT_EQ(replayed.exit_code, 0) << replayed.output;
  const auto again = nlohmann::json::parse(replayed.output, nullptr, false);
  ASSERT_FALSE(again.is_discarded()) << replayed.output;
  EXPECT_EQ(again["same_drawn"], true);
  for (const char* key : {"keyframes", "frames", "nodes", "bytes_down", "max_error_px_frames", "worst_lateness_ms"})
    EXPECT_EQ(again[key], report[key]) << key;

  std::filesystem::resize_file(recording, std::filesystem::file_size(recording) - 50);
  const ProgramResult shortened = runProgram("replay", {recording, "--json"}, {.streams = Streams::kOutputOnly});
  EXPECT_EQ(shortened.exit_code, 0) << shortened.output;
  EXPECT_EQ(nlohmann::json::parse(shortened.output, nullptr, false)["recording_is_whole"], false);
  expectRefusal("replay", {recording + "_none"}, {recording + "_none"});
  expectRefusal("replay", {scene}, {scene, "fly --record"});
}

TEST(FlightProgram, FromNothingToAFlightWithinTolerance) {
  const TemporaryFolder folder;
  const std::string land = folder / "land.tif", scene = folder / "land.fls", frames = folder / "frames",
                    recording = folder / "flight.rec";
  const ProgramResult made = runProgram("synth", {"-o", land, "--size", "257", "--spacing", "30", "--seed", "5"});
  ASSERT_EQ(made.exit_code, 0) << made.output;
  const ProgramResult built = runProgram("build", {land, "-o", scene});
  ASSERT_EQ(built.exit_code, 0) << built.output;
  ASSERT_EQ(runProgram("verify", {scene}).exit_code, 0);

  Program server("serve", {scene, "--listen", "127.0.0.1:0", "--log-level", "off"});
  const std::string url = "ws://127.0.0.1:" + std::to_string(portOf(server.readLine()));
  const ProgramResult flown = runProgram("fly",
                                         {url, "--tour", "survey", "--seconds", "3", "--truth", scene, "--viewport",
                                          "640x360", "--dump", frames, "--record", recording, "--json"},
                                         {.streams = Streams::kOutputOnly});
  ASSERT_EQ(flown.exit_code, 0) << flown.output;
  const auto report = nlohmann::json::parse(flown.output, nullptr, false);
  ASSERT_FALSE(report.is_discarded()) << flown.output;
  EXPECT_GT(report["keyframes"], 0);
  EXPECT_GT(report["triangles"], 0);
  EXPECT_NEAR(report["seconds"], 3, 0.5);
  EXPECT_EQ(report["cracks"], 0);
  EXPECT_EQ(report["uncovered_samples"], 0);
  EXPECT_GT(report["max_error_px_keyframes"], 0);
  EXPECT_LE(report["max_error_px_keyframes"], report["tau_px"]);
  EXPECT_TRUE(std::filesystem::exists(frames + "/frames.jsonl"));

  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
  expectSameReplay(recording, scene, report);

  const std::string other = folder / "other.fls";
  FormulaSource source(65, 65, hills(1));
  ASSERT_TRUE(terrain::buildScene(source, {other, 0.1, 1}).ok());
  const auto benchOver = [&](const std::string& file) {
    return std::vector<std::string>{"sections", file, "--track", recording, "--seconds", "1", "--no-errors"};
  };
  const ProgramResult measured = runProgram("bench", benchOver(scene));
  EXPECT_EQ(measured.exit_code, 0) << measured.output;
  expectRefusal("bench", benchOver(other), {recording, "another scene", other});
}

TEST(FlightProgram, RefusesTheTruthOfAnotherScene) {
  const TemporaryFolder folder;
  const std::string served = folder / "served.fls", other = folder / "other.fls";
  for (const auto& [file, seed] : {std::pair{served, 1}, {other, 2}}) {
    FormulaSource source(65, 65, hills(static_cast<uint64_t>(seed)));
    ASSERT_TRUE(terrain::buildScene(source, {file, 0.1, 1}).ok());
  }
  Program server("serve", {served, "--listen", "127.0.0.1:0", "--log-level", "off"});
  const std::string url = "ws://127.0.0.1:" + std::to_string(portOf(server.readLine()));
  expectRefusal("fly", {url, "--truth", other, "--seconds", "1"}, {other, "not the scene that the server shows"});
  expectRefusal("fly", {url, "--tour", "moon", "--seconds", "1"}, {"moon", "survey"});
}

TEST(FlightProgram, RefusesWhatCannotBeFlown) {
  const TemporaryFolder folder;
  const std::string url = "ws://127.0.0.1:1", missing = folder / "missing", text = folder / "text.igc";
  std::ofstream(text) << "no track\n";
  expectRefusal("fly", {}, {"URL"});
  expectRefusal("fly", {url, "--wings"}, {"--wings", "--help"});
  expectRefusal("fly", {"ftp://127.0.0.1"}, {"ftp://127.0.0.1", "ws://HOST:PORT"});
  expectRefusal("fly", {url}, {url, "foreland serve"});
  expectRefusal("fly", {url, "--truth", missing}, {missing});
  expectRefusal("fly", {url, "--track", missing}, {missing});
  expectRefusal("fly", {url, "--track", text}, {text});
  expectRefusal("fly", {url, "--dump", text}, {text});
  expectRefusal("fly", {url, "--record", missing + "/flight.rec"}, {missing});
  expectRefusal("fly", {url, "--strategy", "wait"}, {"--strategy", "wait", "predict"});
  expectRefusal("fly", {url, "--blend", "b-spline-4"}, {"--blend", "b-spline-4", "b-spline-3"});
  expectRefusal("fly", {url, "--blend", "b-spline-3", "--scene-speed", "90d/s"},
                {"--blend b-spline-3", "--scene-speed", "keyframe"});
  for (const char* interval : {"adaptive", "100-500"})
    expectRefusal("fly", {url, "--blend", "b-spline-2", "--keyframe-ms", interval},
                  {"--blend b-spline-2", interval, "equal intervals"});
  for (const char* option : {"--seconds", "--tau", "--fov"})
    for (const char* value : {"nan", "inf", "-1", "x"}) expectRefusal("fly", {url, option, value}, {option});
  expectRefusal("fly", {url, "--track", text, "--speed", "nan"}, {"--speed"});
}

}  // namespace
}  // namespace foreland::test
