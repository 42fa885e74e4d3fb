// Where the oracles of surfaces see a point: their own projection, by the frame of docs/PROTOCOL.md and nothing else.
// Pixels from the screen's middle, up and to the right. Value type; any thread.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "oracle/stretch.h"
#include "proto/space/pose.h"

namespace foreland::oracle {

struct OracleEye {
  glm::dvec3 at, right, up, forward;
  double focal, half_width, half_height, stretched;

  OracleEye(const proto::Pose& pose, const proto::Lens& lens, const Stretch& stretch = {})
      : at(pose.eye),
        right(stretch(pose.right())),
        up(stretch(pose.up())),
        forward(stretch(pose.forward())),
        focal(lens.focalPx()),
        half_width(0.5 * lens.width_px),
        half_height(0.5 * lens.height_px),
        stretched(stretch.largest()) {}
  double depth(const glm::dvec3& p) const { return glm::dot(p - at, forward); }
  glm::dvec2 project(const glm::dvec3& p) const {
    return glm::dvec2(glm::dot(p - at, right), glm::dot(p - at, up)) * (focal / depth(p));
  }
  // False only if no point of the sphere is in view.
  bool maySee(const glm::dvec3& centre, double true_radius) const {
    const double radius = stretched * true_radius;
    const glm::dvec3 d = centre - at;
    const double ahead = glm::dot(d, forward);
    const auto isWithin = [&](double across, double half) {
      return std::fabs(across) * focal - ahead * half <= radius * std::hypot(focal, half);
    };
    return ahead > -radius && isWithin(glm::dot(d, right), half_width) && isWithin(glm::dot(d, up), half_height);
  }
  bool sees(const glm::dvec2& pixel) const {
    return std::fabs(pixel.x) <= half_width && std::fabs(pixel.y) <= half_height;
  }
};

}  // namespace foreland::oracle
