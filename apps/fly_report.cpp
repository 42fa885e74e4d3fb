#include "apps/fly_report.h"

namespace foreland::apps {

namespace {

using Json = nlohmann::ordered_json;

void addTerm(Json& json, const std::string& name, const bench::TermNorms& term) {
  json[name + "_max_px"] = term.max_px;
  json[name + "_mean_px"] = term.mean_px;
  json[name + "_rms_px"] = term.rms_px;
  json[name + "_max_m"] = term.max_m;
  json[name + "_mean_m"] = term.mean_m;
  json[name + "_rms_m"] = term.rms_m;
}

void addTruth(Json& json, const FlySummary& s) {
  const bench::FlightTruth& t = *s.truth;
  json["max_error_px_keyframes"] = t.keyframes.max_px;
  json["mean_error_px_keyframes"] = t.keyframes.mean_px;
  json["max_error_px_frames"] = t.frames.max_px;
  json["mean_error_px_frames"] = t.frames.mean_px;
  json["rms_error_px_frames"] = t.frames.rms_px;
  json["measured_keyframes"] = t.keyframes.count;
  json["measured_frames"] = t.frames.count;
  json["frames_over_tau"] = t.frames_over_tau;
  json["cracks"] = t.cracks;
  if (!t.first_crack.empty()) json["first_crack"] = t.first_crack;
  json["uncovered_samples"] = t.uncovered_samples;
  json["measure_every"] = t.frame_every;
  json["weights_judged"] = bench::toJson(t.weights_judged);
  json["object_vertices_judged"] = t.object_vertices_judged;
  json["object_silhouette_error_px"] = t.object_silhouette_error_px;
  json["object_interior_error_px"] = t.object_interior_error_px;
  json["object_interior_per_tau"] = t.object_interior_per_tau;
  if (s.has_terms) {
    addTerm(json, "interpolation_error", t.interpolation);
    addTerm(json, "view_error", t.view);
    addTerm(json, "extrapolation_error", t.extrapolation);
  }
  json["lod_motion_max_px"] = t.lod_motion.max_px;
  json["lod_motion_p99_px"] = t.lod_motion_p99_px;
  json["lod_motion_mean_px"] = t.lod_motion.mean_px;
  json["lod_motion_rms_px"] = t.lod_motion.rms_px;
  json["delay_max_ms"] = t.delay_max_ms;
  json["delay_mean_ms"] = t.delay_mean_ms;
}

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
  json["longest_resume_ms"] = f.session.longest_resume.toMilliseconds();
  json["nodes_added"] = f.session.nodes_added;
  json["nodes_removed"] = f.session.nodes_removed;
  json["strategy"] = proto::name(s.request.strategy);
  json["predictor"] = proto::name(s.request.predictor);
  json["blend"] = client::name(s.blend);
  json["tau_px"] = s.request.tau_px;
  json["keyframe_ms"] = s.request.keyframe_interval.toMilliseconds();
  json["worst_lateness_ms"] = f.session.worst_lateness.toMilliseconds();
  if (s.truth) addTruth(json, s);
  if (s.dumped_frames > 0) json["dumped_frames"] = s.dumped_frames;
  json["notes"] = s.notes;
  if (s.error) json["error"] = *s.error;
  return json;
}

}  // namespace

std::string text(const FlySummary& summary, bench::ReportFormat format) {
  return bench::text(reportOf(summary), format);
}

}  // namespace foreland::apps
