// The whole of it, as a newcomer runs it: synth, build, verify, serve, fly, measured against the truth. And what
// `foreland fly` says about bad input.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/apps/advice_files.h"
#include "tests/apps/expect_refusal.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

// Every key of a report, with whatever programs may rely on.
void expectKeys(const nlohmann::json& report, const std::string& keys) {
  std::istringstream words(keys);
  for (std::string key; words >> key;) EXPECT_TRUE(report.contains(key)) << key;
}
constexpr const char* kFlightKeys =
    "keyframes late_keyframes bytes_down bytes_up seconds frames frames_without_mesh frames_outside nodes "
    "triangles mean_nodes mean_triangles resumed started_afresh longest_gap_ms longest_resume_ms "
    "nodes_added nodes_removed tiles tile_bytes texel_px strategy predictor blend tau_px keyframe_ms "
    "longest_keyframe_ms worst_lateness_ms notes ";
constexpr const char* kReplayKeys = "shown_frames sections_hash drawn_hash recording_is_whole same_sections same_drawn";
constexpr const char* kTruthKeys =
    "max_error_px_keyframes mean_error_px_keyframes max_error_px_frames mean_error_px_frames "
    "rms_error_px_frames measured_keyframes measured_frames measure_every weights_judged keyframes_over_tau "
    "frames_over_tau "
    "measured_frames_outside outside_error_p99_px outside_error_max_px cracks uncovered_samples "
    "object_vertices_judged object_silhouette_error_px object_interior_error_px object_interior_per_tau "
    "interpolation_error_max_px interpolation_error_mean_px interpolation_error_rms_px "
    "interpolation_error_max_m interpolation_error_mean_m interpolation_error_rms_m view_error_max_px "
    "view_error_mean_px view_error_rms_px view_error_max_m view_error_mean_m view_error_rms_m "
    "extrapolation_error_max_px extrapolation_error_mean_px extrapolation_error_rms_px "
    "extrapolation_error_max_m extrapolation_error_mean_m extrapolation_error_rms_m lod_motion_max_px "
    "lod_motion_p99_px lod_motion_mean_px lod_motion_rms_px delay_max_ms delay_mean_ms ";

// What a replay reports is what the flight reported. A recording whose last messages are lost ends early.
void expectSameReplay(const std::string& recording, const std::string& scene, const nlohmann::json& report) {
  const ProgramResult replayed =
      runProgram("replay", {recording, "--truth", scene, "--json"}, {.streams = Streams::kOutputOnly});
  ASSERT_EQ(replayed.exit_code, 0) << replayed.output;
  const auto again = nlohmann::json::parse(replayed.output, nullptr, false);
  ASSERT_FALSE(again.is_discarded()) << replayed.output;
  EXPECT_EQ(again["same_drawn"], true);
  expectKeys(again, std::string(kFlightKeys) + kTruthKeys + kReplayKeys);
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
  expectKeys(report, std::string(kFlightKeys) + kTruthKeys);
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
}

std::string lastLine(const std::string& text) {
  return text.empty() ? text : text.substr(text.rfind('\n', text.size() - 2) + 1);
}

// How fast this machine is decides whether all is well.
void expectVerdict(const std::string& text) {
  const std::string last = lastLine(text);
  EXPECT_TRUE(last == "all is well\n" || last.starts_with("not well    ")) << text;
  EXPECT_EQ(text.find('\033'), std::string::npos) << text;
}

TEST(FlightProgram, TellsPeopleWhatCameAndWhetherAllIsWell) {
  const TemporaryFolder folder;
  const std::string scene = folder / "scene.fls", recording = folder / "flight.rec";
  FormulaSource source(129, 129, hills(1));
  ASSERT_TRUE(terrain::buildScene(source, {scene, 0.1, 1}).ok());
  Program server("serve", {scene, "--listen", "127.0.0.1:0", "--log-level", "off"});
  const std::string url = "ws://127.0.0.1:" + std::to_string(portOf(server.readLine()));
  const ProgramResult flown = runProgram("fly",
                                         {url, "--seconds", "2", "--truth", scene, "--truth-frames", "10",
                                          "--truth-terms-every", "2", "--viewport", "640x360", "--record", recording},
                                         {.streams = Streams::kOutputOnly});
  EXPECT_EQ(flown.exit_code, 0) << flown.output;
  EXPECT_TRUE(flown.output.starts_with("flight      ")) << flown.output;
  for (const char* part : {"(asked: 2 s), tour survey", " of 60 a second", " late; at most ", "(asked: one in 200 ms)",
                           " judged frames of ", "(asked: 1 px)", "0 cracks, 0 samples", "interpolation "})
    EXPECT_NE(flown.output.find(part), std::string::npos) << part << " is not in: " << flown.output;
  expectVerdict(flown.output);

  const ProgramResult replayed = runProgram("replay", {recording}, {.streams = Streams::kOutputOnly});
  EXPECT_EQ(replayed.exit_code, 0) << replayed.output;
  EXPECT_NE(replayed.output.find("what is drawn as in the flight"), std::string::npos) << replayed.output;
  EXPECT_EQ(replayed.output.find("judged"), std::string::npos) << replayed.output;
  expectVerdict(replayed.output);

  const ProgramResult few =
      runProgram("replay", {recording, "--truth", scene, "--truth-frames", "10", "--truth-terms-every", "0", "--json"},
                 {.streams = Streams::kOutputOnly});
  const auto report = nlohmann::json::parse(few.output, nullptr, false);
  ASSERT_FALSE(report.is_discarded()) << few.output;
  EXPECT_GT(report["measured_frames"], 5);
  EXPECT_LE(report["measured_frames"], 10);
  EXPECT_FALSE(report.contains("interpolation_error_max_px"));

  const ProgramResult many =
      runProgram("fly", {url, "--seconds", "1", "--viewers", "3"}, {.streams = Streams::kOutputOnly});
  EXPECT_EQ(many.exit_code, 0) << many.output;
  EXPECT_TRUE(many.output.starts_with("viewers     3 of 3 flew to the end")) << many.output;
  expectVerdict(many.output);
}

TEST(FlightProgram, JudgesGlobesAgainstTheirFiles) {
  const TemporaryFolder folder;
  const std::string base = folder / "planet.vrt", inset = folder / "inset.vrt", scene = folder / "planet.fls",
                    recording = folder / "flight.rec";
  const auto ridges = [](int x, int y) { return 900 + 400 * std::sin(0.7 * x) + 300 * std::cos(0.5 * y); };
  writeText(folder / "base.asc", gridText(0, 0, 1, "", hill));
  writeText(base, vrtOver("base.asc", "EPSG:4326", "-180, 5.5384615384615383, 0, 90, 0, -2.7692307692307692", ""));
  writeText(folder / "fine.asc", gridText(0, 0, 1, "", ridges));
  writeText(inset, vrtOver("fine.asc", "EPSG:4326", "7, 0.05, 0, 47, 0, -0.05", ""));
  const ProgramResult built = runProgram("build", {base, "--globe", "--inset", inset, "-o", scene});
  ASSERT_EQ(built.exit_code, 0) << built.output;
  Program server("serve", {scene, "--listen", "127.0.0.1:0", "--log-level", "off"});
  const std::string url = "ws://127.0.0.1:" + std::to_string(portOf(server.readLine()));
  const std::vector<std::string> judged{"--truth",  scene, "--truth-frames", "6",  "--truth-terms-every", "0",
                                        "--source", base,  "--source",       inset};
  std::vector<std::string> flight{url,          "--tour",  "descent:45.4,8.6", "--seconds", "2",
                                  "--viewport", "640x360", "--record",         recording,   "--json"};
  flight.insert(flight.end(), judged.begin(), judged.end());
  const ProgramResult flown = runProgram("fly", flight, {.streams = Streams::kOutputOnly});
  ASSERT_EQ(flown.exit_code, 0) << flown.output;
  const auto report = nlohmann::json::parse(flown.output, nullptr, false);
  ASSERT_FALSE(report.is_discarded()) << flown.output;
  EXPECT_GT(report["source_samples_judged"], 1'000);
  EXPECT_GT(report["source_error_px"], 0);
  // Frames may come to lie outside of a region where the machine is slow.
  EXPECT_EQ(report["keyframes_over_tau"], 0);
  EXPECT_EQ(report["frames_over_tau"], report["outside_frames_over_tau"]);
  EXPECT_EQ(report["uncovered_samples"], 0);

  // The same flight, had the ground been another.
  writeText(folder / "fine.asc", gridText(0, 0, 1, "", [&](int x, int y) { return 4'000 + ridges(x, y); }));
  std::vector<std::string> replay{recording, "--json"};
  replay.insert(replay.end(), judged.begin(), judged.end());
  const ProgramResult other = runProgram("replay", replay, {.streams = Streams::kOutputOnly});
  const auto wrong = nlohmann::json::parse(other.output, nullptr, false);
  ASSERT_FALSE(wrong.is_discarded()) << other.output;
  const double excess_px = wrong["source_excess_px"];
  EXPECT_GT(excess_px, report["source_excess_px"].get<double>() + 1);
  EXPECT_GE(std::max(wrong["max_error_px_frames"].get<double>(), wrong["max_error_px_keyframes"].get<double>()),
            excess_px);
  expectRefusal("replay", {recording, "--truth", scene, "--source", base}, {"inset.vrt", "--source of its own"});
  expectRefusal("replay", {recording, "--truth", scene, "--source", base, "--source", folder / "base.asc"},
                {"inset.vrt"});
}

// Judging this takes minutes, so the signal comes while it lasts.
TEST(FlightProgram, EndsCleanlyWhenItIsInterruptedWhileItJudges) {
  const TemporaryFolder folder;
  const std::string scene = folder / "scene.fls", recording = folder / "flight.rec";
  FormulaSource source(513, 513, noise(1, 60));
  ASSERT_TRUE(terrain::buildScene(source, {scene, 0.1, 1}).ok());
  Program server("serve", {scene, "--listen", "127.0.0.1:0", "--log-level", "off"});
  const std::string url = "ws://127.0.0.1:" + std::to_string(portOf(server.readLine()));
  ASSERT_EQ(runProgram("fly", {url, "--tour", "orbit", "--seconds", "8", "--record", recording}).exit_code, 0);
  Program replay("replay",
                 {recording, "--truth", scene, "--truth-every", "1", "--truth-terms-every", "1", "--threads", "1"});
  ASSERT_EQ(replay.readLine(), "judging frames");
  replay.signal(SIGINT);
  const std::string said = replay.readToEnd();
  EXPECT_EQ(replay.wait(), 2);
  EXPECT_NE(said.find("\nnot well    interrupted while frames were judged"), std::string::npos) << said;
  EXPECT_NE(said.find("foreland replay: interrupted"), std::string::npos) << said;
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
  for (const char* option : {"--truth-frames", "--truth-terms-every", "--threads"})
    for (const char* value : {"-1", "x", "1.5"})
      expectRefusal("fly", {url, "--truth", missing, option, value}, {option});
  expectRefusal("fly", {url, "--threads", "2"}, {"--threads", "--truth"});
  for (const char* option : {"--seconds", "--tau", "--fov"})
    for (const char* value : {"nan", "inf", "-1", "x"}) expectRefusal("fly", {url, option, value}, {option});
  expectRefusal("fly", {url, "--track", text, "--speed", "nan"}, {"--speed"});
}

}  // namespace
}  // namespace foreland::test
