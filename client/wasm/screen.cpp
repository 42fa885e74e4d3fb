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
#include "client/ground_supply.h"
#include "client/imagery/shadows.h"
#include "client/schedule.h"
#include "client/shown_frame.h"
#include "client/wasm/conversions.h"
#include "client/wasm/scene_record.h"
#include "proto/message/message.h"
#include "proto/space/path.h"

namespace foreland::client {
namespace {

struct Screen {
  Schedule schedule;
  CameraPath camera;
  std::optional<proto::Welcome> welcome;
  std::optional<proto::FrameTransform> transform;
  GroundFeed ground;
  proto::Path tour;

  SceneRecord scene_record;
  ScreenRecord screen_record{};
  PoseRecord pose_record{};
  MapPositionRecord place_record{};
  LayerRecord layer_record{};
  SlopeFrameRecord slope_frame_record{};
};

std::optional<proto::TileLayer> reliefOf(const proto::Welcome& welcome) {
  for (const proto::TileLayer& layer : welcome.tile_layers)
    if (layer.content == proto::TileContent::kRelief) return layer;
  return std::nullopt;
}

}  // namespace

FORELAND_EXPORT(foreland_screen_create) Screen* createScreen() { return new Screen(); }

// Adds the Interval in the buffer, which another instance of this module made; meshes before `oldest_version` will not
// be shown any more.
FORELAND_EXPORT(foreland_screen_add) void screenAdd(Screen* screen, uint32_t oldest_version) {
  Interval interval;
  if (incoming().size() != sizeof interval) return;
  std::memcpy(&interval, incoming().data(), sizeof interval);
  screen->schedule.dropBefore(oldest_version);
  screen->schedule.add(interval);
}

// Forgets all meshes: what was ready is lost (foreland_redraw), and those that are added from now on are shown.
FORELAND_EXPORT(foreland_screen_redraw) void screenRedraw(Screen* screen) { screen->schedule.clear(); }

// The version of the mesh to make ready next; 0 if there is none.
FORELAND_EXPORT(foreland_screen_next) uint32_t screenNext(Screen* screen) { return screen->schedule.next(); }

// The camera of the next frame is jumped to (CameraPath::jump).
FORELAND_EXPORT(foreland_screen_jump) void screenJump(Screen* screen) { screen->camera.jump(); }

// What to draw at `now_ms`, if the mesh of version `ready` can be shown and the one that was shown last, with the
// camera at a pose and a proto::Strategy.
FORELAND_EXPORT(foreland_screen_frame)
const ScreenRecord* screenFrame(Screen* screen, double now_ms, double x, double y, double z, double qx, double qy,
                                double qz, double qw, uint32_t strategy, uint32_t ready, uint32_t coming) {
  const proto::Pose pose{.eye = {x, y, z}, .orientation = glm::dquat(qw, qx, qy, qz)};
  screen->camera.add(timeOf(now_ms), pose);
  const Schedule::Shown shown = screen->schedule.at(timeOf(now_ms), ready, coming);
  ScreenRecord& out = screen->screen_record;
  out = {};
  out.pose = recordOf(pose);
  out.next_version = screen->schedule.next();
  if (shown.interval == nullptr) return &out;
  const Interval& interval = *shown.interval;
  const ShownFrame frame = showFrame(shown, screen->camera, pose, static_cast<proto::Strategy>(strategy));
  out.pose = recordOf(frame.pose);
  out.weight = static_cast<float>(shown.weight);
  out.shown_time_ms = millisecondsOf(shown.shown_time);
  out.scene_time_ms = millisecondsOf(interval.from.scene_time) +
                      out.weight * (interval.to.scene_time - interval.from.scene_time).toMilliseconds();
  out.to_time_ms = millisecondsOf(interval.to.time);
  out.to_pose = recordOf(interval.to.pose);
  out.end_ms = millisecondsOf(interval.end);
  out.mesh_version = interval.version;
  out.tau_px = frame.tolerance_px;
  return &out;
}

// Enters the scene of the server's welcome in the buffer. Null if that is no welcome.
FORELAND_EXPORT(foreland_screen_welcome) const WelcomeRecord* screenWelcome(Screen* screen) {
  auto message = proto::decodeServerMessage(incoming());
  if (!message || !std::holds_alternative<proto::Welcome>(*message)) return nullptr;
  screen->welcome = std::move(std::get<proto::Welcome>(*message));
  screen->transform.emplace(screen->welcome->frame);
  return screen->scene_record.fill(*screen->welcome, *screen->transform);
}

// The scene's layer of tiles of a proto::TileContent. Null if it has none.
FORELAND_EXPORT(foreland_screen_layer) const LayerRecord* screenLayer(Screen* screen, uint32_t content) {
  if (!screen->welcome) return nullptr;
  for (const proto::TileLayer& layer : screen->welcome->tile_layers) {
    if (layer.content != static_cast<proto::TileContent>(content)) continue;
    screen->layer_record = recordOf(layer);
    const double quantum_m = screen->welcome->frame.height_quantum_m;
    const auto code = HeightCode::of(layer, screen->welcome->lowest * quantum_m, screen->welcome->highest * quantum_m);
    screen->layer_record.low_m = code.low_m;
    screen->layer_record.code_m = code.step_m;
    return &screen->layer_record;
  }
  return nullptr;
}

// Null before the welcome.
FORELAND_EXPORT(foreland_screen_slope_frame) const SlopeFrameRecord* screenSlopeFrame(Screen* screen) {
  if (!screen->welcome) return nullptr;
  screen->slope_frame_record = slopeFrameOf(screen->welcome->frame);
  return &screen->slope_frame_record;
}

// Takes from the buffer what foreland_ground made.
FORELAND_EXPORT(foreland_screen_ground) void screenGround(Screen* screen) {
  if (screen->welcome) screen->ground.take(incoming(), reliefOf(*screen->welcome));
}

// Where an eye comes to that moves from one point towards another above the ground (client/ground/sweep.h).
FORELAND_EXPORT(foreland_screen_sweep)
const PoseRecord* screenSweep(Screen* screen, double x, double y, double z, double to_x, double to_y, double to_z,
                              double clearance_m) {
  glm::dvec3 eye{to_x, to_y, to_z};
  if (screen->transform) eye = sweep(screen->ground.heights(), *screen->transform, {x, y, z}, eye, clearance_m);
  screen->pose_record = recordOf(proto::Pose{.eye = eye});
  return &screen->pose_record;
}

// A point of the scene in the coordinates of the data's owner. Null before the welcome.
FORELAND_EXPORT(foreland_screen_map_position)
const MapPositionRecord* screenMapPosition(Screen* screen, double x, double y, double z) {
  if (!screen->transform) return nullptr;
  const proto::LatticePosition lattice = screen->transform->toLattice({x, y, z});
  const GroundHeights& heights = screen->ground.heights();
  const auto height_m = heights.heightAt({lattice.x, lattice.y});
  screen->place_record =
      mapPositionOf(*screen->transform, {x, y, z}, height_m.value_or(std::numeric_limits<double>::quiet_NaN()));
  const proto::UndulationGrid& undulations = screen->welcome->vertical.undulations;
  screen->place_record.undulation_m =
      undulations.isEmpty() ? std::numeric_limits<double>::quiet_NaN() : undulations.at({lattice.x, lattice.y});
  screen->place_record.slope_rad = std::numeric_limits<double>::quiet_NaN();
  if (const auto gradient = heights.gradientAt({lattice.x, lattice.y}))
    screen->place_record.slope_rad = slopeOf(*screen->transform, {lattice.x, lattice.y, *height_m}, *gradient);
  return &screen->place_record;
}

// The point of the scene at a place that the data's owner names: latitude and longitude in degrees, or northing and
// easting of the map in metres, and a height above the zero surface. Null before the welcome.
FORELAND_EXPORT(foreland_screen_scene_point)
const PoseRecord* screenScenePoint(Screen* screen, double across_0, double across_1, double height_m) {
  if (!screen->transform) return nullptr;
  screen->pose_record = recordOf(proto::Pose{.eye = scenePointOf(*screen->transform, {across_0, across_1}, height_m)});
  return &screen->pose_record;
}

// Takes the server's reply with a tour from the buffer, to begin at a time. 1 on success.
FORELAND_EXPORT(foreland_screen_tour) uint32_t screenTour(Screen* screen, double start_ms) {
  auto message = proto::decodeServerMessage(incoming());
  if (!message || !std::holds_alternative<proto::TourReply>(*message)) return 0;
  auto& reply = std::get<proto::TourReply>(*message);
  screen->tour = {.start = timeOf(start_ms), .step = reply.step, .poses = std::move(reply.poses)};
  return screen->tour.validate().ok() ? 1 : 0;
}

// The tour's pose at a time; null once the tour is over.
FORELAND_EXPORT(foreland_screen_tour_pose) const PoseRecord* screenTourPose(Screen* screen, double now_ms) {
  if (screen->tour.poses.empty() || timeOf(now_ms) > screen->tour.end()) return nullptr;
  screen->pose_record = recordOf(screen->tour.at(timeOf(now_ms)));
  return &screen->pose_record;
}

}  // namespace foreland::client
