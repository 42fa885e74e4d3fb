// Where a camera is and what it sees. Scene frame, metres; the camera looks along its -z with y up and x right (as
// OpenGL). Value types; any thread; portable to WebAssembly.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "base/time.h"
#include "proto/space/trig.h"

namespace foreland::proto {

struct Pose {
  glm::dvec3 eye{0};                   // scene frame, metres
  glm::dquat orientation{1, 0, 0, 0};  // unit; camera axes to scene axes

  glm::dvec3 forward() const { return orientation * glm::dvec3(0, 0, -1); }
  glm::dvec3 right() const { return orientation * glm::dvec3(1, 0, 0); }
  glm::dvec3 up() const { return orientation * glm::dvec3(0, 1, 0); }
};

struct Lens {
  double vertical_fov_rad = 1.0471975511965976;
  uint32_t width_px = 1920;
  uint32_t height_px = 1080;

  // Pixels on the screen per unit of tangent: a point at camera (x, y, -z) lands at focal * (x/z, y/z) from the centre.
  double focalPx() const { return 0.5 * height_px / tanHalfFov(); }
  double tanHalfFov() const {
    const SinCos half = sinCos(0.5 * vertical_fov_rad);
    return half.sin / half.cos;
  }
  bool operator==(const Lens&) const = default;
};

struct TimedPose {
  Time time;  // the client's clock
  Pose pose;
};

// Largest coordinate of an eye that is accepted, metres; with doubles, distances then err by less than 1e-6 m.
inline constexpr double kMaxEyeCoordinate_m = 1e8;

inline bool isUsable(const Pose& p) {
  const auto fine = [](double v, double limit) { return std::isfinite(v) && std::fabs(v) <= limit; };
  const glm::dquat& q = p.orientation;
  const double norm2 = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  return fine(p.eye.x, kMaxEyeCoordinate_m) && fine(p.eye.y, kMaxEyeCoordinate_m) &&
         fine(p.eye.z, kMaxEyeCoordinate_m) && fine(norm2, 2) && std::fabs(norm2 - 1) < 1e-3;
}

// Field of view between 1 and 170 degrees, viewport between 1 and 16384 pixels a side.
inline bool isUsable(const Lens& l) {
  return std::isfinite(l.vertical_fov_rad) && l.vertical_fov_rad >= 0.017 && l.vertical_fov_rad <= 2.97 &&
         l.width_px >= 1 && l.width_px <= 16384 && l.height_px >= 1 && l.height_px <= 16384;
}

// Orientation that looks along `forward` with `up` as near to vertical as may be; any unit vectors, parallel ones
// included.
glm::dquat lookAlong(const glm::dvec3& forward, const glm::dvec3& up);

// The angle between two orientations, radians; rounded up, and never more than 1e-12 of it (and 1e-15) too large.
inline double angleBetween(const glm::dquat& a, const glm::dquat& b) {
  const glm::dquat d = glm::conjugate(a) * b;
  return 2 * std::asin(std::min(1.0, std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z))) * (1 + 1e-12) + 1e-15;
}

// Position linearly, orientation along the shorter arc; weight 0 gives a, 1 gives b.
Pose interpolate(const Pose& a, const Pose& b, double weight);

}  // namespace foreland::proto
