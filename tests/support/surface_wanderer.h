// A camera that wanders about a surface of size one or so: mostly small steps, now and then a jump, another tolerance,
// region or lens. The same views for the same seed.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>

#include "base/rng.h"
#include "proto/space/view.h"

namespace foreland::test {

class SurfaceWanderer {
 public:
  explicit SurfaceWanderer(uint64_t seed) : rng_(seed) { jump(); }

  proto::View next() {
    switch (rng_.below(25)) {
      case 0:
        jump();
        break;
      case 1:
        view_.tau_px = std::pow(2, rng_.uniform(-2, 5));
        break;
      case 2:
        view_.region_radius_m = rng_.below(2) ? rng_.uniform(0, 0.2) : 0;
        break;
      case 3:
        view_.region_angle_rad = rng_.below(2) ? rng_.uniform(0, 0.5) : 0;
        break;
      case 4:
        view_.lens.vertical_fov_rad = rng_.uniform(0.4, 1.8);
        break;
      case 5:
        return view_;  // no motion at all
      default:
        view_.pose.eye += 0.02 * any();
        look_ += 0.02 * any();
        view_.tau_px *= rng_.uniform(0.99, 1.01);
    }
    view_.pose.orientation = proto::lookAlong(glm::normalize(look_ - view_.pose.eye), {0, 0, 1});
    return view_;
  }

 private:
  glm::dvec3 any() { return {rng_.uniform(-1, 1), rng_.uniform(-1, 1), rng_.uniform(-1, 1)}; }
  void jump() {
    view_.lens = {1.0, 640, 480};
    view_.pose.eye = glm::normalize(any() + glm::dvec3(0.01, 0, 0)) * std::pow(10, rng_.uniform(-0.5, 1.3));
    look_ = 0.5 * any();
  }

  Rng rng_;
  proto::View view_;
  glm::dvec3 look_{0};
};

}  // namespace foreland::test
