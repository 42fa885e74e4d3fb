#include "apps/fly/fly_summary.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace foreland::apps {
namespace {

// A flight of 20 s on which nothing went wrong, as it was asked for.
FlySummary goodFlight() {
  FlySummary s;
  s.course = "tour survey";
  s.asked_s = 20;
  s.request.tau_px = 1;
  s.request.strategy = proto::Strategy::kPredict;
  s.request.predictor = proto::Predictor::kKnownPath;
  s.request.keyframe_interval = Duration::milliseconds(200);
  s.flight.seconds = 20.1;
  s.flight.frames = 1207;
  s.flight.keyframes_flying = 100;
  s.flight.mean_nodes = 197'180;
  s.flight.mean_triangles = 396'957;
  s.flight.longest_gap = Duration::milliseconds(214);
  s.flight.session.bytes_down = 312'400;
  s.flight.session.bytes_up = 13'695;
  return s;
}

oracle::FlightTruth goodTruth() {
  oracle::FlightTruth t;
  t.frames.max_px = 0.9432;
  t.frames.count = 120;
  t.keyframes.max_px = 0.9644;
  t.keyframes.count = 100;
  t.lod_motion.max_px = 0.0807;
  return t;
}

std::string textOf(const FlySummary& s) { return summaryFor(s).text(Paint::kPlain); }

// The last line, which must be about this.
void expectProblem(const FlySummary& s, const std::vector<std::string>& words) {
  const std::string text = textOf(s), last = text.substr(text.rfind('\n', text.size() - 2) + 1);
  EXPECT_TRUE(last.starts_with("not well    ")) << text;
  EXPECT_EQ(text.find("all is well"), std::string::npos) << text;
  for (const std::string& word : words) EXPECT_NE(last.find(word), std::string::npos) << word << " is not in: " << last;
}

TEST(FlySummary, SaysWhatCameBesideWhatWasAskedFor) {
  FlySummary s = goodFlight();
  s.truth = goodTruth();
  EXPECT_EQ(textOf(s),
            "flight      20.1 s (asked: 20 s), tour survey, strategy predict, predictor path, blend keyframe\n"
            "frames      60.0 of 60 a second, 1,207 in all\n"
            "keyframes   100, 0 late; at most 214 ms apart (asked: one in 200 ms)\n"
            "received    312 kB, 15.5 kB/s; sent 13.7 kB\n"
            "triangles   397,000 on average, of 197,000 nodes\n"
            "guaranteed  in 1,207 of 1,207 frames\n"
            "error       0.943 px at most in 120 judged frames of 1,207 (asked: 1 px)\n"
            "            0.964 px at most in 100 judged keyframes\n"
            "surface     0 cracks, 0 samples in view not covered\n"
            "motion      0.0807 px at most in a 60th of a second by the change of detail\n"
            "all is well\n");
}

TEST(FlySummary, NamesBudgetsThatWereAskedFor) {
  FlySummary s = goodFlight();
  s.request.max_triangles = 500'000;
  s.request.max_bytes_per_second = 25'000;
  const std::string text = textOf(s);
  EXPECT_NE(text.find("397,000 on average, of 197,000 nodes (asked: at most 500,000)"), std::string::npos) << text;
  EXPECT_NE(text.find("15.5 kB/s (asked: at most 25.0 kB/s)"), std::string::npos) << text;
}

TEST(FlySummary, SaysWhatIsNotWellAndWhatToDo) {
  FlySummary s = goodFlight();
  s.flight.late_keyframes_flying = 3;
  expectProblem(s, {"3 of 100 keyframes came late", "--tau", "--keyframe-ms"});
  s = goodFlight();
  s.flight.frames = 600;
  expectProblem(s, {"29.9 frames a second, not 60", "--viewport"});
  s = goodFlight();
  s.flight.frames_without_mesh = 7;
  expectProblem(s, {"7 frames had nothing to show"});
  s = goodFlight();
  s.flight.frames_outside = 24;
  expectProblem(s, {"24 of 1,207 frames", "--predictor path"});
  s = goodFlight();
  s.error = "the server sent no answer";
  expectProblem(s, {"the server sent no answer"});
}

TEST(FlySummary, SaysWhatTheJudgeFound) {
  FlySummary s = goodFlight();
  s.truth = goodTruth();
  s.truth->cracks = 2;
  s.truth->first_crack = "an edge";
  expectProblem(s, {"2 cracks", "an edge", "--record"});
  s.truth = goodTruth();
  s.truth->uncovered_samples = 1;
  expectProblem(s, {"1 sample in view not covered", "--record"});
  s.truth = goodTruth();
  s.truth->frames_over_tau = 5;
  s.truth->outside_over_tau = 2;
  expectProblem(s, {"3 of 120 judged frames", "--record"});
  s.blend = client::Blend::kGeomorph;
  expectProblem(s, {"3 of 120 judged frames", "--blend keyframe"});
  s.truth = goodTruth();
  s.truth->keyframes_over_tau = 1;
  expectProblem(s, {"1 of ", "judged keyframes", "--blend keyframe"});
  s.blend = client::Blend::kKeyframe;
  expectProblem(s, {"1 of ", "judged keyframes", "--record"});
}

// A camera that leaves the regions exceeds the tolerance there, which is no fault; that it leaves them is told.
TEST(FlySummary, DoesNotBlameTheJudgedFramesThatNothingWasGuaranteedFor) {
  FlySummary s = goodFlight();
  s.flight.frames_outside = 24;
  s.truth = goodTruth();
  s.truth->frames_over_tau = s.truth->outside_over_tau = s.truth->outside_measured = 2;
  s.truth->outside_max_px = 3.21;
  const std::string text = textOf(s);
  EXPECT_EQ(text.find("are above the tolerance"), std::string::npos) << text;
  EXPECT_NE(text.find("3.21 px at most in the 2 of them for which nothing is guaranteed"), std::string::npos) << text;
  expectProblem(s, {"24 of 1,207 frames"});
}

TEST(FlySummary, DoesNotBlameWhoJumpsOrSteers) {
  FlySummary s = goodFlight();
  s.flight.frames_outside = 24;
  s.flight.jumps = {{.kind = "far", .jumps = 5, .recovered = 5, .worst_recovery = Duration::milliseconds(412)}};
  EXPECT_TRUE(textOf(s).ends_with("all is well\n")) << textOf(s);
  EXPECT_NE(textOf(s).find("far: at 1 px again after 5 of 5 jumps, within 412 ms"), std::string::npos) << textOf(s);
  s.flight.jumps.clear();
  s.is_steered = true;
  s.flight.frames = 600;  // at the rate of a screen
  EXPECT_TRUE(textOf(s).ends_with("all is well\n")) << textOf(s);
}

TEST(FlySummary, ComparesAReplayWithTheFlight) {
  FlySummary s = goodFlight();
  const client::FlightDigest::Value shown{.frames = 1200, .sections = 1, .drawn = 2};
  s.replayed = ReplayedDigest{shown, shown};
  EXPECT_NE(textOf(s).find("sections as in the flight, what is drawn as in the flight"), std::string::npos);
  EXPECT_TRUE(textOf(s).ends_with("all is well\n"));
  s.replayed->recorded->drawn = 3;
  expectProblem(s, {"what is drawn is not", "another compiler"});
  s.replayed->recorded->sections = 3;
  expectProblem(s, {"the sections are not the flight's"});
  s.replayed->recorded.reset();
  EXPECT_NE(textOf(s).find("the recording ends early"), std::string::npos);
}

TEST(FlySummary, KeepsToAboutFifteenLines) {
  FlySummary s = goodFlight();
  s.flight.session.tiles = 5;
  s.flight.session.resumed = 1;
  s.truth = goodTruth();
  s.truth->has_terms = true;
  s.truth->object_vertices_judged = 9;
  s.dumped_frames = 3;
  s.notes = {"lifted 3 poses"};
  const std::string text = textOf(s);
  EXPECT_LE(std::ranges::count(text, '\n'), 17) << text;
}

}  // namespace
}  // namespace foreland::apps
