// What a host's drawing thread computes for a frame, without the viewer, which lives in another thread: what is shown
// when (schedule.h), where the camera was, and the ground about it. The other thread hands over the intervals of new
// meshes, the server's welcome, and what GroundSupply makes. One owner; times are the client's clock.
#pragma once

#include <optional>

#include "client/ground/ray.h"
#include "client/ground_supply.h"
#include "client/places.h"
#include "client/schedule.h"
#include "client/shown_frame.h"
#include "proto/message/message.h"

namespace foreland::client {

// What to draw in a frame.
struct ScreenFrame {
  std::optional<Interval> interval;  // that is shown; nothing: there is no mesh yet
  proto::Pose pose;                  // the camera: as given, or M(t_d) with strategy `delay`
  double weight = 0;
  Time shown_time{};
  double scene_time_us = 0;   // whose ground is shown, since 1970, in scenes with epochs
  float tolerance_px = 0;     // as FrameView::tolerance_px
  uint32_t next_version = 0;  // of the mesh to make ready; 0: none
};

// A place of the scene with the ground there, as far as it is held.
struct ScreenPlace {
  MapPosition at;
  std::optional<double> ground_m, slope_rad;
  std::optional<double> undulation_m;  // of the geoid above the ellipsoid
};

struct Screen {
  Schedule schedule;
  CameraPath camera;
  std::optional<proto::Welcome> welcome;
  std::optional<proto::FrameTransform> transform;
  SceneBox box;  // about the data
  GroundFeed ground;

  void enter(proto::Welcome told);
  // Meshes before `oldest_version` will not be shown any more.
  void add(const Interval& interval, uint32_t oldest_version);
  // As of Schedule::at. To be called once for each frame, with times that do not decrease.
  ScreenFrame frame(Time now, const FrameCamera& seen, proto::Strategy strategy, uint32_t ready, uint32_t coming);
  // Takes what GroundSupply::update made.
  void takeGround(ByteSpan update);

  // After the welcome only.
  ScreenPlace placeAt(const glm::dvec3& point) const;
  // Where a ray meets the ground that is held (client/ground/ray.h).
  std::optional<glm::dvec3> groundOn(const Ray& ray) const;
};

}  // namespace foreland::client
