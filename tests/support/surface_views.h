// Random views of a surface about the origin, by which oracles judge refined surfaces.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "proto/refine/surface/surface_metric.h"
#include "proto/space/pose.h"
#include "tests/support/surfaces.h"

namespace foreland::test {

inline constexpr proto::Lens kScreen{1.0471975511965976, 640, 480};

inline proto::Pose lookAt(const glm::dvec3& eye, const glm::dvec3& target) {
  return {eye, proto::lookAlong(glm::normalize(target - eye), {0, 0, 1})};
}

// A view and its test: from 1.2 to 12 away, with separate tolerances, with and without a region.
struct SurfaceView {
  proto::View view;
  proto::SurfaceTest test;
};
inline SurfaceView anySurfaceView(Rng& rng, bool is_closed) {
  SurfaceView made;
  const glm::dvec3 from = glm::normalize(anyPoint(rng) + glm::dvec3(0, 0, 1e-3)) * rng.uniform(1.2, 12);
  made.view.pose = lookAt(from, anyPoint(rng));
  made.view.lens = kScreen;
  made.view.tau_px = rng.uniform(0.3, 2);
  made.test.interior_px = made.view.tau_px * rng.uniform(1, 7);
  made.view.region_radius_m = rng.below(2) * 0.1;
  made.view.region_angle_rad = rng.below(2) * 0.2;
  made.test.nearest_m = 0.05;
  made.test.is_closed = is_closed;
  return made;
}

// A random pose in the region of the view.
inline proto::Pose anyPoseOf(const proto::View& view, Rng& rng) {
  proto::Pose pose = view.pose;
  if (view.region_radius_m > 0) pose.eye += anyPoint(rng) * (view.region_radius_m / std::sqrt(3.0));
  const glm::dvec3 axis = glm::normalize(anyPoint(rng) + glm::dvec3(1e-3, 0, 0));
  pose.orientation = glm::angleAxis(rng.uniform() * view.region_angle_rad, axis) * pose.orientation;
  return pose;
}

}  // namespace foreland::test
