// A camera's perspective: the ray through a pixel, and where a point lies on the screen. Immutable; any thread.
#pragma once

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "terrain/render/picture.h"
#include "terrain/render/ray_caster.h"

namespace foreland::terrain {

class Projector {
 public:
  explicit Projector(const Camera& camera)
      : eye_(camera.pose.eye),
        right_(camera.pose.right()),
        up_(camera.pose.up()),
        forward_(camera.pose.forward()),
        focal_px_(camera.lens.focalPx()),
        middle_(0.5 * camera.lens.width_px, 0.5 * camera.lens.height_px) {}

  // Through the pixel's middle; row 0 is the upmost. Its direction is a unit vector.
  Ray through(uint32_t column, uint32_t row) const {
    const double x = (column + 0.5 - middle_.x) / focal_px_, y = (middle_.y - row - 0.5) / focal_px_;
    return {eye_, glm::normalize(forward_ + x * right_ + y * up_)};
  }
  // Metres ahead of the eye; negative behind it.
  double depth(const glm::dvec3& point) const { return glm::dot(point - eye_, forward_); }
  // In pixels, between points ahead of the eye.
  double screenDistance(const glm::dvec3& a, const glm::dvec3& b) const {
    return glm::distance(project(a), project(b));
  }

 private:
  glm::dvec2 project(const glm::dvec3& point) const {
    return glm::dvec2(glm::dot(point - eye_, right_), glm::dot(point - eye_, up_)) * (focal_px_ / depth(point));
  }

  glm::dvec3 eye_, right_, up_, forward_;
  double focal_px_;
  glm::dvec2 middle_;
};

}  // namespace foreland::terrain
