#include "apps/fly/fly_report.h"

namespace foreland::apps {

namespace {

using Json = nlohmann::ordered_json;

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
  if (s.truth) json.update(bench::toJson(*s.truth));
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
