#include "apps/fly/fly_summary.h"

#include <algorithm>
#include <cmath>

#include "apps/options/date.h"

namespace foreland::apps {

namespace {

constexpr double kFramesPerSecond = 60, kFewFramesPerSecond = 57;  // asked for; fewer are a problem

std::string asked(const std::string& what) { return " (asked: " + what + ")"; }

std::string keyframeInterval(const proto::ViewRequest& request) {
  const double min_ms = request.keyframe_interval.toMilliseconds(), max_ms = request.longest_interval.toMilliseconds();
  if (min_ms == 0) return "as the server likes";
  return max_ms > 0 ? "one in " + shortest(min_ms) + " to " + shortest(max_ms) + " ms"
                    : "one in " + shortest(min_ms) + " ms";
}

void addFlight(const FlySummary& s, Summary& out) {
  std::string flight = digits(s.flight.seconds) + " s";
  if (s.asked_s) flight += asked(shortest(*s.asked_s) + " s");
  out.add("flight", flight + ", " + s.course + ", strategy " + proto::name(s.request.strategy) + ", predictor " +
                        proto::name(s.request.predictor) + ", blend " + client::name(s.blend) +
                        (s.exaggeration != 1 ? ", heights " + shortest(s.exaggeration) + " times as tall" : ""));
  if (s.flight.scene_first) out.add("scene", dateText(*s.flight.scene_first) + " to " + dateText(*s.flight.scene_last));
}

void addFrames(const FlySummary& s, Summary& out) {
  const client::FlightReport& f = s.flight;
  const double rate = f.seconds > 0 ? static_cast<double>(f.frames) / f.seconds : 0;
  out.add("frames", digits(rate) + (s.is_steered ? "" : " of " + shortest(kFramesPerSecond)) + " a second, " +
                        count(f.frames) + " in all");
  if (f.frames_without_mesh > 0) {
    out.add("", count(f.frames_without_mesh) + " of them with nothing to show");
    out.addProblem(count(f.frames_without_mesh, "frame") + " had nothing to show",
                   "the first keyframe came too late: see how busy the server and the link are");
  }
  if (!s.is_steered && !s.replayed && rate < kFewFramesPerSecond && f.seconds >= 1)
    out.addProblem("this machine drew " + digits(rate) + " frames a second, not " + shortest(kFramesPerSecond),
                   "ask for less (--tau, --viewport, --max-triangles), or leave it more of its processors");
}

void addKeyframes(const FlySummary& s, Summary& out) {
  const client::FlightReport& f = s.flight;
  out.add("keyframes", count(f.keyframes_flying) + ", " + count(f.late_keyframes_flying) + " late; at most " +
                           millisecondsText(f.longest_gap.toMilliseconds()) + " apart" +
                           asked(keyframeInterval(s.request)));
  if (f.late_keyframes_flying > 0)
    out.addProblem(count(f.late_keyframes_flying) + " of " + count(f.keyframes_flying, "keyframe") + " came late",
                   "the server or the link is too slow: ask for less (--tau, --max-kbit), or more seldom "
                   "(--keyframe-ms)");
}

void addTransfer(const FlySummary& s, Summary& out) {
  const client::ViewerStatistics& session = s.flight.session;
  const double down = static_cast<double>(session.bytes_down), seconds = std::max(s.flight.seconds, 1e-3);
  std::string received = bytesText(down) + ", " + bytesText(down / seconds) + "/s";
  if (s.request.max_bytes_per_second > 0)
    received += asked("at most " + bytesText(s.request.max_bytes_per_second) + "/s");
  out.add("received", received + "; sent " + bytesText(static_cast<double>(session.bytes_up)));
  if (session.tiles > 0)
    out.add("tiles", count(session.tiles) + ", " + bytesText(static_cast<double>(session.tile_bytes)));
  if (session.resumed + session.started_afresh > 0)
    out.add("connection", "lost and made again: " + count(session.resumed, "time") + " resumed, " +
                              count(session.started_afresh) + " from nothing, within " +
                              millisecondsText(session.longest_resume.toMilliseconds()));
}

void addSizes(const FlySummary& s, Summary& out) {
  std::string triangles = digits(s.flight.mean_triangles) + " on average, of " + digits(s.flight.mean_nodes) + " nodes";
  if (s.request.max_triangles > 0) triangles += asked("at most " + shortest(s.request.max_triangles));
  out.add("triangles", triangles);
}

// How many frames the error is guaranteed for. Jumps leave every region by nature, and so does who steers.
void addGuarantee(const FlySummary& s, Summary& out) {
  const client::FlightReport& f = s.flight;
  const uint64_t shown = f.frames - f.frames_without_mesh;
  out.add("guaranteed", "in " + count(shown - std::min(shown, f.frames_outside)) + " of " + count(shown, "frame"));
  if (f.frames_outside > 0 && f.jumps.empty() && !s.is_steered)
    out.addProblem(count(f.frames_outside) + " of " + count(shown, "frame") +
                       " were seen from where no keyframe guarantees the error",
                   "a predictor that knows more (--predictor path) or a shorter --keyframe-ms helps");
}

void addJumps(const FlySummary& s, Summary& out) {
  for (const client::JumpReport& jump : s.flight.jumps)
    out.add("jump", jump.kind + ": at " + shortest(s.request.tau_px) + " px again after " + count(jump.recovered) +
                        " of " + count(jump.jumps, "jump") + ", within " +
                        millisecondsText(jump.worst_recovery.toMilliseconds()) + ", " +
                        millisecondsText(jump.mean_recovery.toMilliseconds()) + " on average");
}

void addErrors(const FlySummary& s, const oracle::FlightTruth& t, Summary& out) {
  out.add("error", digits(t.frames.max_px) + " px at most in " + count(t.frames.count) + " judged frames of " +
                       count(s.flight.frames) + asked(shortest(s.request.tau_px) + " px"));
  out.add("", digits(t.keyframes.max_px) + " px at most in " + count(t.keyframes.count, "judged keyframe"));
  if (t.outside_measured > 0)
    out.add("", digits(t.outside_max_px) + " px at most in the " + count(t.outside_measured) +
                    " of them for which nothing is guaranteed");
  if (t.has_terms)
    out.add("terms", "interpolation " + digits(t.interpolation.max_px) + " px, view " + digits(t.view.max_px) +
                         " px, extrapolation " + digits(t.extrapolation.max_px) + " px at most");
  if (t.object_vertices_judged > 0)
    out.add("objects", digits(t.object_silhouette_error_px) + " px at most on silhouettes, " +
                           digits(t.object_interior_error_px) + " px inside" +
                           asked(shortest(t.object_interior_per_tau * s.request.tau_px) + " px inside"));
  if (t.source_samples_judged > 0)
    out.add("files", digits(t.source_error_px) + " px at most from their samples, " + digits(t.source_excess_px) +
                         " px more than the residual that the scene states looks like");
  out.add("surface", count(t.cracks, "crack") + ", " + count(t.uncovered_samples, "sample") + " in view not covered");
  out.add("motion", digits(t.lod_motion.max_px) + " px at most in a 60th of a second by the change of detail");
  if (t.delay_max_ms > 0)
    out.add("delay",
            millisecondsText(t.delay_mean_ms) + " on average, " + millisecondsText(t.delay_max_ms) + " at most");
}

// A fault of the program's: whoever finds one can help.
const char* const kTellUs = "this is a fault: record the flight (--record) and report it";

void addJudgement(const FlySummary& s, Summary& out) {
  const oracle::FlightTruth& t = *s.truth;
  const uint64_t over_inside = t.frames_over_tau - t.outside_over_tau;
  if (t.cracks > 0) out.addProblem(count(t.cracks, "crack") + ", the first: " + t.first_crack, kTellUs);
  if (t.uncovered_samples > 0) out.addProblem(count(t.uncovered_samples, "sample") + " in view not covered", kTellUs);
  const char* const advice =
      s.blend != client::Blend::kGeomorph ? kTellUs : "geomorphs do not guarantee it: --blend keyframe does";
  const auto addOver = [&](uint64_t over, uint64_t judged, const char* what) {
    if (over > 0) out.addProblem(count(over) + " of " + count(judged, what) + " are above the tolerance", advice);
  };
  addOver(t.keyframes_over_tau, t.keyframes.count, "judged keyframe");
  addOver(over_inside, t.frames.count, "judged frame");
}

void addReplayed(const ReplayedDigest& r, Summary& out) {
  std::string what = count(r.shown.frames, "frame") + " shown";
  if (!r.recorded) {
    out.add("replay", what + "; the recording ends early, so there is nothing to compare them with");
    return;
  }
  const bool same_sections = r.shown.sections == r.recorded->sections, same_drawn = r.shown == *r.recorded;
  out.add("replay", what + "; sections " + (same_sections ? "" : "not ") + "as in the flight, what is drawn " +
                        (same_drawn ? "" : "not ") + "as in the flight");
  if (!same_sections)
    out.addProblem("the sections are not the flight's", "the recording or the client has changed");
  else if (!same_drawn)
    out.addProblem("what is drawn is not what the flight drew",
                   "so it is after a change of the client, or with another compiler");
}

}  // namespace

Summary summaryFor(const FlySummary& s) {
  Summary out;
  addFlight(s, out);
  addFrames(s, out);
  addKeyframes(s, out);
  addTransfer(s, out);
  addSizes(s, out);
  addJumps(s, out);
  addGuarantee(s, out);
  if (s.replayed) addReplayed(*s.replayed, out);
  if (s.truth) {
    addErrors(s, *s.truth, out);
    addJudgement(s, out);
  }
  if (s.dumped_frames > 0) out.add("dumped", count(s.dumped_frames, "frame"));
  for (const std::string& note : s.notes) out.add("note", note);
  if (s.error) out.addProblem(*s.error);
  return out;
}

}  // namespace foreland::apps
