#include "apps/fly/fly_report.h"

#include <array>
#include <cstdint>
#include <cstdio>

#include "apps/fly/fly_summary.h"
#include "apps/options/date.h"

namespace foreland::apps {

namespace {

using Json = nlohmann::ordered_json;

Json jumpsOf(const std::vector<client::JumpReport>& jumps) {
  Json all = Json::object();
  for (const client::JumpReport& jump : jumps)
    all[jump.kind] = {{"jumps", jump.jumps},
                      {"recovered", jump.recovered},
                      {"recovery_ms", jump.worst_recovery.toMilliseconds()},
                      {"mean_recovery_ms", jump.mean_recovery.toMilliseconds()},
                      {"unguaranteed_ms", jump.worst_without.toMilliseconds()},
                      {"largest_tolerance_px", jump.largest_tolerance_px},
                      {"late_coarse_frames", jump.late_coarse_frames}};
  return all;
}

std::string hex(uint64_t number) {
  std::array<char, 17> text;
  std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(number));
  return text.data();
}

void addReplayed(const ReplayedDigest& replayed, Json& json) {
  json["shown_frames"] = replayed.shown.frames;
  json["sections_hash"] = hex(replayed.shown.sections);
  json["drawn_hash"] = hex(replayed.shown.drawn);
  json["recording_is_whole"] = replayed.recorded.has_value();
  if (!replayed.recorded) return;
  json["same_sections"] = replayed.shown.sections == replayed.recorded->sections;
  json["same_drawn"] = replayed.shown == *replayed.recorded;
}

}  // namespace

Json reportOf(const FlySummary& s) {
  const client::FlightReport& f = s.flight;
  Json json;
  json["keyframes"] = f.keyframes_flying;
  json["late_keyframes"] = f.late_keyframes_flying;
  json["bytes_down"] = f.session.bytes_down;
  json["bytes_up"] = f.session.bytes_up;
  json["seconds"] = f.seconds;
  json["frames"] = f.frames;
  json["frames_without_mesh"] = f.frames_without_mesh;
  json["frames_outside"] = f.frames_outside;
  json["nodes"] = f.nodes;
  json["triangles"] = f.triangles;
  json["mean_nodes"] = f.mean_nodes;
  json["mean_triangles"] = f.mean_triangles;
  json["resumed"] = f.session.resumed;
  json["started_afresh"] = f.session.started_afresh;
  json["longest_gap_ms"] = f.longest_gap.toMilliseconds();
  json["longest_resume_ms"] = f.session.longest_resume.toMilliseconds();
  json["nodes_added"] = f.session.nodes_added;
  json["nodes_removed"] = f.session.nodes_removed;
  json["tiles"] = f.session.tiles;
  json["tile_bytes"] = f.session.tile_bytes;
  json["texel_px"] = f.session.texel_px;
  json["strategy"] = proto::name(s.request.strategy);
  json["predictor"] = proto::name(s.request.predictor);
  json["blend"] = client::name(s.blend);
  json["tau_px"] = s.request.tau_px;
  if (s.exaggeration != 1) json["exaggeration"] = s.exaggeration;
  json["keyframe_ms"] = s.request.keyframe_interval.toMilliseconds();
  json["longest_keyframe_ms"] = s.request.longest_interval.toMilliseconds();
  json["worst_lateness_ms"] = f.session.worst_lateness.toMilliseconds();
  if (f.scene_first) json["scene_first"] = dateText(*f.scene_first), json["scene_last"] = dateText(*f.scene_last);
  if (!f.jumps.empty()) json["jumps"] = jumpsOf(f.jumps);
  if (s.replayed) addReplayed(*s.replayed, json);
  if (s.truth) json.update(apps::toJson(*s.truth));
  if (s.dumped_frames > 0) json["dumped_frames"] = s.dumped_frames;
  json["notes"] = s.notes;
  if (s.error) json["error"] = *s.error;
  return json;
}

const char* reportHelp() {
  return R"(
Without --json it prints a summary for people, whose last line says whether all is well, or what is not. NO_COLOR is respected.
Report (--json prints one object with these keys):
  keyframes, late_keyframes     received while flying; those that arrived after the time they were to be shown from
  bytes_down, bytes_up          everything since the connection was made, the first section included
  seconds, frames               flown; shown
  frames_without_mesh           shown before the first keyframe arrived
  frames_outside                drawn from a pose for which a keyframe does not guarantee its tolerance
  nodes, triangles              of the last section and mesh; mean_nodes, mean_triangles over all frames
  resumed, started_afresh       new connections, by what their first keyframe started from; longest_resume_ms
  longest_gap_ms                between the arrivals of two keyframes, while flying
  nodes_added, nodes_removed    in all keyframes
  tiles, tile_bytes, texel_px   with --relief or --imagery: tiles received, their bytes, and by layer the largest texel on the
                                screen by the server's last statement
  jumps                         with --tour jumps, by kind: jumps and how many the tolerance was held again after; recovery_ms
                                (worst, from the jump to the first frame that holds it) and mean_recovery_ms; unguaranteed_ms
                                (worst, to the first frame that guarantees anything); largest_tolerance_px of those that do;
                                late_coarse_frames (later than 400 ms, above 8 px or without a guarantee)
  strategy, predictor, blend, tau_px, keyframe_ms, longest_keyframe_ms, worst_lateness_ms, notes
  scene_first, scene_last       dates that were shown, in scenes that change in time
With --viewers N: viewers, landed (flew to the end), error (the first), the sums of the figures above, and of the viewers' longest
gaps all (longest_gaps_ms), the median, the 99th percentile and the longest (longest_gap_p50_ms, longest_gap_p99_ms, longest_gap_ms)
With --truth SCENE, measured after landing on a replay of the flight:
  max_error_px_keyframes        each keyframe's section seen from the pose it was computed for (geomorphs: as it is
                                drawn at its time)
  max_error_px_frames           frames as they were drawn, one in --truth-every
  keyframes_over_tau, frames_over_tau   those above the tolerance that they state
  measured_frames, measured_keyframes   how many were judged
  outside_error_p99_px, outside_error_max_px, outside_frames_over_tau   of measured_frames_outside of these, which were outside
                                of a keyframe's region
  cracks, uncovered_samples     of terrain and objects; must be 0
  measure_every, measure_keyframes_every, weights_judged   the strides that were taken; how many weights between two keyframes
                                were judged
  object_silhouette_error_px, object_interior_error_px   largest on the silhouettes of objects, and inside, where tau times
                                object_interior_per_tau is guaranteed; max_error_px_* count the latter divided by that
  source_error_px, source_excess_px   with --source: largest distance of a file's sample from what is drawn; what of it is more than
                                the residual that the scene states looks like there, which max_error_px_* count
  source_samples_judged         how often one was looked at
  interpolation_error_*, view_error_*, extrapolation_error_*   the terms of THEORY section 4 apart: max, mean and rms, in _px and
                                _m; mean is that over frames of the largest in each
  lod_motion_*_px               what the change of detail alone moves in a 60th of a second; p99 of what moves
  delay_max_ms, delay_mean_ms   t - t_d
`foreland replay` adds what the replay showed:
  shown_frames, sections_hash, drawn_hash   frames with a mesh; hashes of all keyframes' sections and heights (the same on every
                                machine), and of all that is drawn (the same for one build)
  recording_is_whole            false if the program that recorded was killed; else same_sections and same_drawn say whether the
                                replay showed what the flight did
)";
}

FlySummary summaryOf(const client::Player& player) {
  const client::PlayerOptions& options = player.log().options;
  FlySummary summary{.course = options.is_steered ? "by hand"
                               : options.track    ? "a track"
                                                  : "tour " + options.tour,
                     .asked_s = options.track ? options.track_options.seconds : options.seconds,
                     .is_steered = options.is_steered,
                     .request = options.request,
                     .exaggeration = options.exaggeration.factor,
                     .blend = options.blend,
                     .flight = player.report(),
                     .truth = {},
                     .notes = {},
                     .error = {},
                     .replayed = {}};
  summary.request.tau_px *= options.exaggeration.finer;
  if (options.is_steered) summary.asked_s.reset();
  if (options.track) summary.notes = options.track->notes;
  summary.notes.insert(summary.notes.end(), player.notes().begin(), player.notes().end());
  return summary;
}

Status addAfterwards(Afterwards& afterwards, const client::FlightLog& log, ReportFormat format, FlySummary& summary) {
  const Result<uint64_t> dumped = afterwards.dump(log);
  Status status = dumped.ok() ? Status() : dumped.error();
  if (dumped.ok()) summary.dumped_frames = *dumped;
  summary.truth = afterwards.measure(log, format == ReportFormat::kJson ? 1 : 0);
  if (summary.truth && !summary.truth->is_whole)
    status = Error{ErrorCode::kIo, "interrupted while frames were judged: errors are those of the beginning"};
  if (!status.ok() && !summary.error) summary.error = status.error().message;
  return status;
}

void print(const FlySummary& summary, ReportFormat format) {
  const std::string printed =
      format == ReportFormat::kJson ? text(reportOf(summary), format) : summaryFor(summary).text(paintFor(stdout));
  std::fputs(printed.c_str(), stdout);
}

}  // namespace foreland::apps
