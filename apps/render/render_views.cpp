#include "apps/render/render_views.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <string>

#include "apps/options/place.h"
#include "client/fly/track_path.h"
#include "client/fly/tracks/track.h"
#include "server/view/ground.h"
#include "server/view/tour.h"

namespace foreland::apps {

namespace {

constexpr double kDegree = 0.017453292519943295;
constexpr double kTourSeconds = 60;

Error refused(const std::string& pose, const std::string& why) {
  return {ErrorCode::kInvalidArgument, "--pose '" + pose + "': " + why};
}

proto::Pose poseAt(const proto::FrameTransform& transform, const proto::LatticePosition& at, double heading_deg,
                   double pitch_deg) {
  const glm::dvec3 eye = transform.toScene(at), up = transform.upAt(eye);
  const glm::dvec3 north = glm::normalize(glm::dvec3(0, 1, 0) - up * up.y), east = glm::cross(north, up);
  const double heading = heading_deg * kDegree, pitch = pitch_deg * kDegree;
  const glm::dvec3 level = std::cos(heading) * north + std::sin(heading) * east;
  return {eye, proto::lookAlong(std::cos(pitch) * level + std::sin(pitch) * up, up)};
}

Result<proto::Pose> parsePose(const std::string& text, const terrain::Scene& scene) {
  const auto numbers = numbersOf(text);
  if (!numbers || numbers->size() < 3 || numbers->size() > 5)
    return refused(text,
                   "write LAT,LON,HEIGHT[,HEADING[,PITCH]] in degrees and metres (x and y of a planar scene's map)");
  const std::vector<double>& n = *numbers;
  const proto::FrameTransform transform(scene.frame());
  const bool is_planar = scene.frame().kind == proto::FrameKind::kPlanar;
  if (!is_planar && (std::fabs(n[0]) > 90 || std::fabs(n[1]) > 360))
    return refused(text, "the scene is geographic: latitude and longitude in degrees come first");
  proto::LatticePosition at = latticeOf(transform, n[0], n[1]);
  const std::optional<double> ground_m = server::groundHeight(scene, at.x, at.y);
  if (!ground_m)
    return refused(text, std::string("lies beyond the data; `foreland info` tells where that is, ") +
                             (is_planar ? "x and y are the map's, in metres" : "latitude and longitude are degrees"));
  if (n[2] < 0) return refused(text, "lies under the ground; HEIGHT is metres above it");
  const double pitch_deg = n.size() > 4 ? n[4] : 0;
  if (std::fabs(pitch_deg) > 90) return refused(text, "PITCH is -90 to 90 degrees above the horizon");
  at.height_m = *ground_m + n[2];
  const proto::Pose pose = poseAt(transform, at, n.size() > 3 ? n[3] : 0, pitch_deg);
  if (!proto::isUsable(pose)) return refused(text, "too high or too far to be computed with");
  return pose;
}

Result<proto::Path> trackPath(const RenderOptions& o, const client::Track& track, const terrain::Scene& scene,
                              std::vector<std::string>& notes) {
  const proto::FrameTransform transform(scene.frame());
  Result<client::PlannedTrack> plan = client::planTrack(track, transform, scene.grid().shape(), o.track_options);
  if (!plan.ok()) return plan.error();
  plan->undulations_m = server::seaAboveZero(scene, plan->positions);
  std::vector<float> ground_m;
  for (const glm::dvec2& place : plan->positions)
    ground_m.push_back(static_cast<float>(server::groundHeight(scene, place.x, place.y).value_or(0)));
  Result<client::TrackPath> path = client::pathOverGround(*plan, transform, ground_m, o.track_options);
  if (!path.ok()) return path.error();
  for (const auto& some : {track.notes, plan->notes, path->notes}) notes.insert(notes.end(), some.begin(), some.end());
  return std::move(path->path);
}

}  // namespace

Result<Views> viewsOf(const RenderOptions& o, const std::optional<client::Track>& track, const terrain::Scene& scene) {
  Views views;
  if (o.pose) {
    const Result<proto::Pose> pose = parsePose(*o.pose, scene);
    if (!pose.ok()) return pose.error();
    views.poses = {*pose};
    return views;
  }
  const Result<proto::Path> path = track ? trackPath(o, *track, scene, views.notes)
                                         : server::planTour(scene, *o.tour, o.seconds.value_or(kTourSeconds));
  if (!path.ok()) return path.error();
  const Duration step = Duration::seconds(o.every_s);
  for (Time t = path->start; t <= path->end(); t = t + step) views.poses.push_back(path->at(t));
  return views;
}

}  // namespace foreland::apps
