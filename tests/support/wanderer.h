// A wandering camera over a scene: mostly small steps, now and then a turn, a jump, another tolerance, region or
// lens. The same views for the same seed.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>

#include "base/rng.h"
#include "server/section/hierarchy.h"

namespace foreland::test {

// At a lattice position and a height (m), looking along an azimuth and down by -pitch.
inline proto::View viewAt(const server::Hierarchy& h, double x, double y, double height, double yaw, double pitch) {
  proto::View view;
  view.pose.eye = h.frame().transform().toScene(proto::LatticePosition{x, y, height});
  glm::dvec3 ahead(std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch), std::sin(pitch)), up(0, 0, 1);
  if (h.grid().isCube()) {  // by the ground below
    up = h.frame().transform().upAt(view.pose.eye);
    const glm::dvec3 east =
        glm::normalize(glm::cross(std::fabs(up.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0), up));
    ahead = ahead.x * east + ahead.y * glm::cross(up, east) + ahead.z * up;
  }
  view.pose.orientation = proto::lookAlong(ahead, up);
  view.lens = {1.0, 640, 360};
  return view;
}

class Wanderer {
 public:
  Wanderer(const server::Hierarchy& h, uint64_t seed) : hierarchy_(h), rng_(seed) { jump(); }

  proto::View next() {
    const proto::GridShape& shape = hierarchy_.grid().shape();
    switch (rng_.below(30)) {
      case 0:
        jump();
        break;
      case 1:
        yaw_ += rng_.uniform(-2, 2);
        break;
      case 2:
        tau_ = std::pow(2, rng_.uniform(-3, 3));
        break;
      case 3:
        region_radius_m_ = rng_.uniform(0, 60);
        break;
      case 4:
        region_angle_rad_ = rng_.below(2) ? rng_.uniform(0, 0.5) : 0;
        break;
      case 5:
        fov_ = rng_.uniform(0.4, 1.8);
        break;
      case 6:
        return last_;  // no motion at all
      default:
        x_ += rng_.uniform(-1.5, 1.5);
        y_ += rng_.uniform(-1.5, 1.5);
        height_ += rng_.uniform(-20, 20);
        yaw_ += rng_.uniform(-0.02, 0.02);
        tau_ *= rng_.uniform(0.98, 1.02);
    }
    last_ = viewAt(hierarchy_, std::fmod(x_ + shape.samples_x, shape.samples_x),
                   std::fmod(y_ + shape.samples_y, shape.samples_y), height_, yaw_, pitch_);
    last_.tau_px = tau_;
    last_.region_radius_m = region_radius_m_;
    last_.region_angle_rad = region_angle_rad_;
    last_.lens.vertical_fov_rad = fov_;
    return last_;
  }

 private:
  void jump() {
    x_ = rng_.uniform(0, hierarchy_.grid().shape().samples_x);
    y_ = rng_.uniform(0, hierarchy_.grid().shape().samples_y);
    height_ = 500 + std::pow(10, rng_.uniform(1, 4));
    yaw_ = rng_.uniform(0, 6.28);
    pitch_ = rng_.uniform(-1.5, 0.3);
  }

  const server::Hierarchy& hierarchy_;
  Rng rng_;
  double x_ = 0, y_ = 0, height_ = 0, yaw_ = 0, pitch_ = 0, tau_ = 1, region_radius_m_ = 0, region_angle_rad_ = 0,
         fov_ = 1;
  proto::View last_;
};

}  // namespace foreland::test
