// The player, the server's session and the oracle together, in virtual time over a link of 20 ms, no sockets.
#include <gtest/gtest.h>

#include "client/fly/recorded_path.h"
#include "client/fly/recording.h"
#include "client/mesh/weights/morph_timing.h"
#include "oracle/flight_piece.h"
#include "tests/oracle/virtual_flight.h"
#include "tests/support/files.h"

namespace foreland::oracle {
namespace {

TEST(Flight, KeepsToleranceInEveryFrameWithoutCracksOrExtrapolationErrorOnAKnownPath) {
  const Flight flight = flown(tourOptions(proto::Strategy::kPredict));
  ASSERT_TRUE(flight.status.ok()) << flight.status.error().message;
  const client::FlightReport report = flight.player.report();
  EXPECT_EQ(report.late_keyframes_flying, 0u);
  EXPECT_GE(report.keyframes_flying, 19u);
  EXPECT_EQ(report.frames_without_mesh, 0u);
  EXPECT_NEAR(report.seconds, 4, 0.2);
  const FlightTruth truth = measured(flight.player);
  EXPECT_EQ(truth.cracks, 0u) << truth.first_crack;
  EXPECT_EQ(truth.uncovered_samples, 0u);
  EXPECT_LE(truth.keyframes.max_px, 1.0);
  EXPECT_GT(truth.keyframes.max_px, 0.3);  // a bound that nothing comes near would cost too many triangles
  EXPECT_LT(truth.extrapolation.max_px, 0.01);
  EXPECT_EQ(report.frames_outside, 0u);
  EXPECT_EQ(truth.outside_measured, 0u);
  EXPECT_EQ(truth.frames_over_tau, 0u) << truth.frames.max_px;
  EXPECT_EQ(truth.delay_max_ms, 0);
  EXPECT_GT(truth.lod_motion.max_px, 0);
  EXPECT_LE(truth.lod_motion.max_px, 2.0 / 12 * 1.1);  // 2 tau over the frames of 200 ms
}

TEST(Flight, KeepsTheToleranceOfThePictureWhereHeightsAreTaller) {
  client::PlayerOptions options = tourOptions(proto::Strategy::kPredict);
  options.tour = "canyon";
  options.exaggeration = client::Exaggeration::of(3, options.request.lens);
  options.request.lens = options.exaggeration.asked;
  options.request.tau_px = 1 / options.exaggeration.finer;
  const Flight flight = flown(options);
  ASSERT_TRUE(flight.status.ok()) << flight.status.error().message;
  EXPECT_EQ(flight.player.report().frames_outside, 0u);
  const FlightTruth truth = measured(flight.player);
  EXPECT_EQ(truth.cracks, 0u) << truth.first_crack;
  EXPECT_EQ(truth.uncovered_samples, 0u);
  EXPECT_GT(truth.frames.count, 5u);
  // Judged in the picture, where the same errors are drawn taller than the camera that was asked for sees them.
  client::FlightLog as_asked = flight.player.log();
  as_asked.options.exaggeration = {};
  SceneOracle oracle(truthOf(alps()));
  const FlightTruth asked =
      measureFlight(as_asked, oracle, {.frame_every = 20, .sections = apps::exactSectionsOf(alps())});
  EXPECT_LE(asked.frames.max_px, 1 / options.exaggeration.finer + kSlack_px);
  EXPECT_GT(truth.frames.max_px, 2 * asked.frames.max_px);
  EXPECT_EQ(truth.frames_over_tau, 0u) << truth.frames.max_px;
  EXPECT_EQ(truth.keyframes_over_tau, 0u) << truth.keyframes.max_px;
  EXPECT_LE(truth.frames.max_px, 1 + kSlack_px);
}

// A camera that turns by more than its region promises: errors above the tolerance are outside of regions alone.
TEST(Flight, TellsTheErrorsOfFramesOutsideOfRegionsApart) {
  client::PlayerOptions options = tourOptions(proto::Strategy::kPredict);
  options.tour = "spin";
  options.request.predictor = proto::Predictor::kHold;
  options.knowledge = client::PathKnowledge::kPrivate;
  const Flight flight = flown(options);
  const FlightTruth truth = measured(flight.player);
  EXPECT_GT(flight.player.report().frames_outside, 20u);
  EXPECT_GT(truth.outside_measured, 0u);
  EXPECT_LE(truth.outside_measured, truth.frames.count);
  EXPECT_GT(truth.outside_max_px, 1);
  EXPECT_GE(truth.outside_max_px, truth.outside_p99_px);
  EXPECT_EQ(truth.outside_max_px, truth.frames.max_px);
}

// A frame between two keyframes of a flight, with all that its judgement needs but a tolerance.
FlightPiece pieceBetweenKeyframes() {
  const Flight flight = flown(tourOptions(proto::Strategy::kPredict));
  FlightPiece piece;
  piece.shape = alps()->grid().shape();
  piece.lens = flight.player.log().options.request.lens;
  client::replay(flight.player.log(), [&](const client::Player& player, Time) {
    if (!player.view().mesh || player.view().weight == 0) return true;
    piece.mesh = std::make_shared<client::KeyframeMesh>(*player.view().mesh);
    piece.shown = FlightPiece::Frame();
    piece.shown->pose = player.view().pose;
    return false;
  });
  return piece;
}

// A frame between two keyframes states the coarser one's tolerance, a keyframe its own.
TEST(Flight, JudgesFramesAndKeyframesByWhatEachStates) {
  SceneOracle oracle(truthOf(alps()));
  FlightPiece piece = pieceBetweenKeyframes();
  ASSERT_TRUE(piece.mesh);
  const double error_px = FlightJudge(oracle, {}).judge(piece).shown->max_px;
  ASSERT_GT(error_px, 0.1);
  piece.keyframe.emplace();
  for (const double finer : {0.5, 2.0}) {
    client::KeyframeMesh mesh = *piece.mesh;
    mesh.to.tau_px = static_cast<float>(finer * error_px);
    piece.mesh = std::make_shared<client::KeyframeMesh>(mesh);
    piece.shown->tolerance_px = 1.5 * error_px;
    EXPECT_FALSE(FlightJudge(oracle, {}).judge(piece).is_over_tolerance);
    piece.shown->tolerance_px = 0.9 * error_px;
    EXPECT_TRUE(FlightJudge(oracle, {}).judge(piece).is_over_tolerance);
  }
  client::KeyframeMesh mesh = *piece.mesh;
  for (const bool is_over : {true, false}) {
    mesh.to.tau_px = is_over ? 0.01f : 4.0f;
    piece.mesh = std::make_shared<client::KeyframeMesh>(mesh);
    EXPECT_EQ(FlightJudge(oracle, {}).judge(piece).is_keyframe_over_tolerance, is_over);
  }
}

// What a frame states may be finer than its keyframes' tolerance, where its picture is smaller than theirs.
TEST(Flight, CountsHiddenErrorsUpToWhatAFrameStates) {
  SceneOracle oracle(truthOf(alps()));
  FlightPiece piece = pieceBetweenKeyframes();
  ASSERT_TRUE(piece.mesh);
  const double error_px = FlightJudge(oracle, {}).judge(piece).shown->max_px;
  client::KeyframeMesh mesh = *piece.mesh;
  for (const double keyframe : {0.1, 1.0, 10.0}) {
    mesh.to.tau_px = static_cast<float>(keyframe * error_px);
    piece.mesh = std::make_shared<client::KeyframeMesh>(mesh);
    piece.shown->tolerance_px = 0.5 * error_px;
    oracle.judgeOnlySeen([](const glm::dvec3&, const glm::dvec3&) { return false; });
    const FlightJudgement hidden = FlightJudge(oracle, {}).judge(piece);
    EXPECT_FALSE(hidden.is_over_tolerance);
    EXPECT_GT(hidden.shown->max_px, 0.9 * piece.shown->tolerance_px);
    oracle.judgeOnlySeen([](const glm::dvec3&, const glm::dvec3&) { return true; });
    EXPECT_TRUE(FlightJudge(oracle, {}).judge(piece).is_over_tolerance);
  }
}

TEST(Flight, OverASceneWithObjectsKeepsTheirTolerancesToo) {
  client::PlayerOptions options = tourOptions(proto::Strategy::kPredict);
  options.tour = "orbit";
  const Flight flight = flown(options, test::objectsIn(*alps(), 12));
  ASSERT_TRUE(flight.status.ok()) << flight.status.error().message;
  const FlightTruth truth = measured(flight.player, test::objectsIn(*alps(), 12));
  EXPECT_EQ(truth.cracks, 0u) << truth.first_crack;
  EXPECT_EQ(truth.uncovered_samples, 0u);
  EXPECT_EQ(truth.frames_over_tau, 0u) << truth.frames.max_px;
  EXPECT_GT(truth.object_vertices_judged, 1000u);
  EXPECT_GT(truth.object_silhouette_error_px, 0.1);
  EXPECT_LE(truth.object_silhouette_error_px, 1.01);
  EXPECT_LE(truth.object_interior_error_px, 1.01 * truth.object_interior_per_tau);
  EXPECT_EQ(truth.frame_every, 23u);  // 20 was asked for, of 12 frames a keyframe
  EXPECT_EQ(truth.weights_judged.distinct(), truth.frames.count);
}

TEST(Flight, WithGeomorphsMovesLessAtATimeAndIsNeverFarAboveTheTolerance) {
  client::PlayerOptions options = tourOptions(proto::Strategy::kPredict);
  const FlightTruth keyframes = measured(flown(options).player);
  options.blend = client::Blend::kGeomorph;
  const FlightTruth geomorphs = measured(flown(options).player);
  EXPECT_EQ(geomorphs.cracks, 0u) << geomorphs.first_crack;
  EXPECT_EQ(geomorphs.uncovered_samples, 0u);
  EXPECT_LT(geomorphs.lod_motion.rms_px, keyframes.lod_motion.rms_px);
  EXPECT_LT(geomorphs.frames.max_px, 1 / (1 - client::MorphTiming::kMoved));
  EXPECT_NE(geomorphs.frames.rms_px, keyframes.frames.rms_px);
}

TEST(Flight, WithAHigherOrderKeepsTheToleranceInEveryFrame) {
  for (proto::Strategy strategy : {proto::Strategy::kPredict, proto::Strategy::kDelay})
    for (client::Blend blend : {client::Blend::kKeyframe, client::Blend::kSpline2, client::Blend::kSpline3}) {
      SCOPED_TRACE(std::string(proto::name(strategy)) + ' ' + client::name(blend));
      client::PlayerOptions options = tourOptions(strategy);
      options.blend = blend;
      const Flight flight = flown(options);
      ASSERT_TRUE(flight.status.ok()) << flight.status.error().message;
      const client::FlightReport report = flight.player.report();
      EXPECT_EQ(report.late_keyframes_flying, 0u);
      // With delay nothing is known of how the camera will begin to move.
      EXPECT_LE(report.frames_outside, strategy == proto::Strategy::kPredict ? 0u : 24u);
      const FlightTruth truth = measured(flight.player);
      std::printf("%s, %s: %.3f px, %.0f triangles, %lu outside\n", client::name(blend), proto::name(strategy),
                  truth.frames.max_px, report.mean_triangles, static_cast<unsigned long>(report.frames_outside));
      EXPECT_EQ(truth.cracks, 0u) << truth.first_crack;
      EXPECT_EQ(truth.uncovered_samples, 0u);
      EXPECT_EQ(truth.frames_over_tau, 0u) << truth.frames.max_px;
      EXPECT_GT(truth.frames.max_px, 0.3);
    }
}

TEST(Flight, WithDelayShowsThePastWithoutViewError) {
  const FlightTruth truth = measured(flown(tourOptions(proto::Strategy::kDelay)).player);
  EXPECT_LE(truth.keyframes.max_px, 1.0);
  EXPECT_GT(truth.delay_mean_ms, 200);
  EXPECT_EQ(truth.view.count, 0u);
  EXPECT_GT(truth.interpolation.count, 0u);
}

TEST(Flight, WithCurrentPaysInViewErrorInstead) {
  const FlightTruth truth = measured(flown(tourOptions(proto::Strategy::kCurrent)).player);
  EXPECT_GT(truth.view.max_px, 0);
  EXPECT_EQ(truth.view.count, truth.interpolation.count);
}

TEST(Flight, IsTheSameWhenReplayed) {
  const Flight flight = flown(tourOptions(proto::Strategy::kPredict));
  std::optional<client::FlightReport> again;
  client::replay(flight.player.log(), [&](const client::Player& player, Time) {
    again = player.report();
    return true;
  });
  ASSERT_TRUE(again);
  const client::FlightReport first = flight.player.report();
  EXPECT_EQ(again->frames, first.frames);
  EXPECT_EQ(again->mean_triangles, first.mean_triangles);
  EXPECT_EQ(again->nodes, first.nodes);
  EXPECT_EQ(again->session.bytes_down, first.session.bytes_down);
  EXPECT_EQ(again->session.bytes_up, first.session.bytes_up);
}

TEST(Flight, FliesATrackAboveTheGroundThatTheServerTells) {
  constexpr double kDeg = 0.017453292519943295;
  client::Track track;
  for (int i = 0; i <= 30; ++i)
    track.fixes.push_back({i * 1.0, (46.03 + i * 5e-4) * kDeg, (8.03 + i * 5e-4) * kDeg, 0});  // far under ground
  client::PlayerOptions options = tourOptions(proto::Strategy::kPredict);
  options.track = std::make_shared<const client::Track>(track);
  options.track_options = {.speed = 10, .clearance_m = 30};
  const Flight flight = flown(options);
  ASSERT_TRUE(flight.status.ok()) << flight.status.error().message;
  EXPECT_EQ(flight.player.notes().size(), 1u);  // lifted
  const proto::FrameTransform frame(alps()->frame());
  for (const proto::Pose& pose : flight.player.path().poses) {
    const proto::LatticePosition place = frame.toLattice(pose.eye);
    // Not lower than the lowest corner of the cell below.
    const auto x = static_cast<uint32_t>(place.x), y = static_cast<uint32_t>(place.y);
    int32_t ground = alps()->height(proto::NodeId::at(x, y));
    for (const auto corner :
         {proto::NodeId::at(x + 1, y), proto::NodeId::at(x, y + 1), proto::NodeId::at(x + 1, y + 1)})
      ground = std::min(ground, alps()->height(corner));
    EXPECT_GE(place.height_m, ground * 0.1 + 30 - 0.01);
  }
}

TEST(Flight, EndsWithTheServersWordsWhenItRefuses) {
  client::PlayerOptions options = tourOptions(proto::Strategy::kPredict);
  options.tour = "grand";
  const Flight flight = flown(options);
  ASSERT_FALSE(flight.status.ok());
  EXPECT_NE(flight.status.error().message.find("grand"), std::string::npos);
}

TEST(Flight, GivesUpOnASilentServer) {
  client::Player player(tourOptions(proto::Strategy::kPredict));
  ASSERT_TRUE(player.frame(Time::seconds(1)).ok());
  ASSERT_TRUE(player.frame(Time::seconds(10)).ok());
  const Status status = player.frame(Time::seconds(12));
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().message.find("waited 10 s for a welcome"), std::string::npos);
}

void record(const std::filesystem::path& file, const client::FlightLog& log) {
  auto writer = client::RecordingWriter::create(file, log.options);
  ASSERT_TRUE(writer.ok());
  ASSERT_TRUE(writer->append(log.entries).ok());
}

// The same flight as if a person had steered it.
client::FlightLog steered(const client::Player& player) {
  client::FlightLog log = player.log();
  log.options.is_steered = true;
  for (client::FlightLog::Entry& entry : log.entries)
    if (entry.what == client::FlightLog::What::kFrame) {
      entry.what = client::FlightLog::What::kSteered;
      entry.pose = player.path().at(entry.time);
    }
  return log;
}

TEST(RecordedFlight, GivesThePathThatWasFlown) {
  const test::TemporaryFolder folder;
  const Flight flight = flown(tourOptions(proto::Strategy::kPredict));
  ASSERT_TRUE(flight.status.ok());
  const proto::Path& path = flight.player.path();
  record(folder / "planned.rec", flight.player.log());
  record(folder / "steered.rec", steered(flight.player));
  const double length_s = (path.end() - path.start).toSeconds();
  for (const char* name : {"planned.rec", "steered.rec"}) {
    ASSERT_TRUE(client::isRecording(folder / name));
    const Time began = std::string(name) == "planned.rec" ? path.start : flight.player.log().entries.front().time;
    const double from_s = (path.start - began).toSeconds() + 1, speed = 2;
    const auto recorded = client::readRecordedPath(folder / name, {.speed = speed, .from_s = from_s});
    ASSERT_TRUE(recorded.ok()) << recorded.error().message;
    EXPECT_EQ(recorded->scene_id, alps()->id());
    EXPECT_TRUE(recorded->path.validate().ok());
    EXPECT_NEAR((recorded->path.end() - recorded->path.start).toSeconds(), (length_s - 1) / speed, 0.11) << name;
    // Paths are smooth between their poses but for the ends, where they hold still.
    const double margin_s = recorded->path.step.toSeconds();
    int compared = 0;
    for (double t = margin_s; t < (length_s - 1) / speed - 0.1 - margin_s; t += 0.0137, ++compared) {
      const proto::Pose expected = path.at(path.start + Duration::seconds(1 + speed * t)),
                        pose = recorded->path.at(Time{} + Duration::seconds(t));
      ASSERT_NEAR(glm::distance(pose.eye, expected.eye), 0, 0.05) << name << " at " << t;
      ASSERT_NEAR(proto::angleBetween(pose.orientation, expected.orientation), 0, 1e-3) << name << " at " << t;
    }
    EXPECT_GT(compared, 50);
  }
}

TEST(RecordedFlight, IsRefusedWhereItHasNoPath) {
  const test::TemporaryFolder folder;
  client::PlayerOptions jumps = tourOptions(proto::Strategy::kCurrent);
  jumps.tour = "jumps";
  record(folder / "jumps.rec", {jumps, {}});
  record(folder / "short.rec", {tourOptions(proto::Strategy::kCurrent), {}});
  const Flight flight = flown(tourOptions(proto::Strategy::kPredict));
  record(folder / "whole.rec", flight.player.log());
  const auto expectRefusal = [&](const char* name, const client::TrackOptions& options, const std::string& words) {
    const auto recorded = client::readRecordedPath(folder / name, options);
    ASSERT_FALSE(recorded.ok()) << name;
    EXPECT_NE(recorded.error().message.find(words), std::string::npos) << recorded.error().message;
  };
  expectRefusal("jumps.rec", {}, "jumps");
  expectRefusal("short.rec", {}, "before the flight began");
  expectRefusal("none.rec", {}, "none.rec");
  expectRefusal("whole.rec", {.from_s = 1e6}, "--from");
  expectRefusal("whole.rec", {.from_s = -1}, "--from");
  expectRefusal("whole.rec", {.speed = 0}, "--speed");
  expectRefusal("whole.rec", {.agl_m = 50}, "--agl");
  EXPECT_FALSE(client::isRecording(folder / "none.rec"));
}

}  // namespace
}  // namespace foreland::oracle
