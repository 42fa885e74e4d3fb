// What the page's drawing thread computes for a frame, without the viewer, which lives in a worker with another
// instance of this module: what is shown when (client/schedule.h), where the camera is on a tour, and where it is on
// the map. The worker hands over the intervals of new meshes, the server's welcome and tours as they came, and the
// ground about the eye. Times are milliseconds of the page's clock. One thread; records stay valid until the next call
// into the module.
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <variant>

#include "client/ground/sweep.h"
#include "client/imagery/shadows.h"
#include "client/screen.h"
#include "client/wasm/conversions.h"
#include "client/wasm/scene_record.h"
#include "proto/message/message.h"
#include "proto/space/path.h"

namespace foreland::client {
namespace {

struct ScreenHost {
  Screen screen;
  proto::Path tour;

  SceneRecord scene_record;
  ScreenRecord screen_record{};
  PoseRecord pose_record{};
  MapPositionRecord place_record{};
  LayerRecord layer_record{};
  SlopeFrameRecord slope_frame_record{};
};

}  // namespace

FORELAND_EXPORT(foreland_screen_create) ScreenHost* createScreen() { return new ScreenHost(); }

// Adds the Interval in the buffer, which another instance of this module made; meshes before `oldest_version` will not
// be shown any more.
FORELAND_EXPORT(foreland_screen_add) void screenAdd(ScreenHost* host, uint32_t oldest_version) {
  Interval interval;
  if (incoming().size() != sizeof interval) return;
  std::memcpy(&interval, incoming().data(), sizeof interval);
  host->screen.add(interval, oldest_version);
}

// Forgets all meshes: what was ready is lost (foreland_redraw), and those that are added from now on are shown.
FORELAND_EXPORT(foreland_screen_redraw) void screenRedraw(ScreenHost* host) { host->screen.schedule.clear(); }

// The version of the mesh to make ready next; 0 if there is none.
FORELAND_EXPORT(foreland_screen_next) uint32_t screenNext(ScreenHost* host) { return host->screen.schedule.next(); }

// The camera of the next frame is jumped to (CameraPath::jump).
FORELAND_EXPORT(foreland_screen_jump) void screenJump(ScreenHost* host) { host->screen.camera.jump(); }

// What to draw at `now_ms`, if the mesh of version `ready` can be shown and the one that was shown last, with the
// camera at a pose, with a lens, eyes that are `eye_radius_m` from it at most, and a proto::Strategy.
FORELAND_EXPORT(foreland_screen_frame)
const ScreenRecord* screenFrame(ScreenHost* host, double now_ms, double x, double y, double z, double qx, double qy,
                                double qz, double qw, double fov_rad, uint32_t width_px, uint32_t height_px,
                                double eye_radius_m, uint32_t strategy, uint32_t ready, uint32_t coming) {
  const FrameCamera seen{.pose = {.eye = {x, y, z}, .orientation = glm::dquat(qw, qx, qy, qz)},
                         .lens = {fov_rad, width_px, height_px},
                         .eye_radius_m = eye_radius_m};
  const ScreenFrame frame =
      host->screen.frame(timeOf(now_ms), seen, static_cast<proto::Strategy>(strategy), ready, coming);
  ScreenRecord& out = host->screen_record;
  out = {};
  out.pose = recordOf(frame.pose);
  out.next_version = frame.next_version;
  if (!frame.interval) return &out;
  const Interval& interval = *frame.interval;
  out.weight = static_cast<float>(frame.weight);
  out.shown_time_ms = millisecondsOf(frame.shown_time);
  out.scene_time_ms = frame.scene_time_us / 1000;
  out.to_time_ms = millisecondsOf(interval.to.time);
  out.to_pose = recordOf(interval.to.pose);
  out.end_ms = millisecondsOf(interval.end);
  out.mesh_version = interval.version;
  out.tau_px = frame.tolerance_px;
  return &out;
}

// Enters the scene of the server's welcome in the buffer. Null if that is no welcome.
FORELAND_EXPORT(foreland_screen_welcome) const WelcomeRecord* screenWelcome(ScreenHost* host) {
  auto message = proto::decodeServerMessage(incoming());
  if (!message || !std::holds_alternative<proto::Welcome>(*message)) return nullptr;
  host->screen.enter(std::move(std::get<proto::Welcome>(*message)));
  return host->scene_record.fill(*host->screen.welcome, *host->screen.transform);
}

// The scene's layer of tiles of a proto::TileContent. Null if it has none.
FORELAND_EXPORT(foreland_screen_layer) const LayerRecord* screenLayer(ScreenHost* host, uint32_t content) {
  if (!host->screen.welcome) return nullptr;
  for (const proto::TileLayer& layer : host->screen.welcome->tile_layers) {
    if (layer.content != static_cast<proto::TileContent>(content)) continue;
    host->layer_record = recordOf(layer);
    const double quantum_m = host->screen.welcome->frame.height_quantum_m;
    const auto code =
        HeightCode::of(layer, host->screen.welcome->lowest * quantum_m, host->screen.welcome->highest * quantum_m);
    host->layer_record.low_m = code.low_m;
    host->layer_record.code_m = code.step_m;
    return &host->layer_record;
  }
  return nullptr;
}

// Null before the welcome.
FORELAND_EXPORT(foreland_screen_slope_frame) const SlopeFrameRecord* screenSlopeFrame(ScreenHost* host) {
  if (!host->screen.welcome) return nullptr;
  host->slope_frame_record = slopeFrameOf(host->screen.welcome->frame);
  return &host->slope_frame_record;
}

// Takes from the buffer what foreland_ground made.
FORELAND_EXPORT(foreland_screen_ground) void screenGround(ScreenHost* host) { host->screen.takeGround(incoming()); }

// Where an eye comes to that moves from one point towards another above the ground (client/ground/sweep.h).
FORELAND_EXPORT(foreland_screen_sweep)
const PoseRecord* screenSweep(ScreenHost* host, double x, double y, double z, double to_x, double to_y, double to_z,
                              double clearance_m) {
  glm::dvec3 eye{to_x, to_y, to_z};
  if (host->screen.transform)
    eye = sweep(host->screen.ground.heights(), *host->screen.transform, {x, y, z}, eye, clearance_m);
  host->pose_record = recordOf(proto::Pose{.eye = eye});
  return &host->pose_record;
}

// Where a ray meets the ground that is held, at most so far away (client/ground/ray.h). Null if it does not, and before
// the welcome.
FORELAND_EXPORT(foreland_screen_ray)
const PoseRecord* screenRay(ScreenHost* host, double x, double y, double z, double along_x, double along_y,
                            double along_z, double far_m) {
  const glm::dvec3 direction{along_x, along_y, along_z};
  if (!host->screen.transform || direction == glm::dvec3(0)) return nullptr;
  const auto hit = host->screen.groundOn({{x, y, z}, direction, far_m});
  if (!hit) return nullptr;
  host->pose_record = recordOf(proto::Pose{.eye = *hit});
  return &host->pose_record;
}

// A point of the scene in the coordinates of the data's owner. Null before the welcome.
FORELAND_EXPORT(foreland_screen_map_position)
const MapPositionRecord* screenMapPosition(ScreenHost* host, double x, double y, double z) {
  if (!host->screen.transform) return nullptr;
  const ScreenPlace place = host->screen.placeAt({x, y, z});
  host->place_record = mapPositionRecordOf(place);
  return &host->place_record;
}

// The point of the scene at a place that the data's owner names: latitude and longitude in degrees, or northing and
// easting of the map in metres, and a height above the zero surface. Null before the welcome.
FORELAND_EXPORT(foreland_screen_scene_point)
const PoseRecord* screenScenePoint(ScreenHost* host, double across_0, double across_1, double height_m) {
  if (!host->screen.transform) return nullptr;
  host->pose_record =
      recordOf(proto::Pose{.eye = scenePointOf(*host->screen.transform, {across_0, across_1}, height_m)});
  return &host->pose_record;
}

// Takes the server's reply with a tour from the buffer, to begin at a time. 1 on success.
FORELAND_EXPORT(foreland_screen_tour) uint32_t screenTour(ScreenHost* host, double start_ms) {
  auto message = proto::decodeServerMessage(incoming());
  if (!message || !std::holds_alternative<proto::TourReply>(*message)) return 0;
  auto& reply = std::get<proto::TourReply>(*message);
  host->tour = {.start = timeOf(start_ms), .step = reply.step, .poses = std::move(reply.poses)};
  return host->tour.validate().ok() ? 1 : 0;
}

// The tour's pose at a time; null once the tour is over.
FORELAND_EXPORT(foreland_screen_tour_pose) const PoseRecord* screenTourPose(ScreenHost* host, double now_ms) {
  if (host->tour.poses.empty() || timeOf(now_ms) > host->tour.end()) return nullptr;
  host->pose_record = recordOf(host->tour.at(timeOf(now_ms)));
  return &host->pose_record;
}

}  // namespace foreland::client
