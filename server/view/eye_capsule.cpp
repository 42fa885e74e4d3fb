#include "server/view/eye_capsule.h"

#include <algorithm>
#include <glm/geometric.hpp>

namespace foreland::server {

namespace {

double distanceTo(const EyeCapsule& capsule, const glm::dvec3& p) {
  const double length = glm::dot(capsule.way, capsule.way);
  const double share = length > 0 ? std::clamp(glm::dot(p - capsule.eye, capsule.way) / length, 0.0, 1.0) : 0.0;
  return glm::distance(capsule.eye + share * capsule.way, p);
}

}  // namespace

// The distance from a segment is convex, so along the other's segment it is largest at an end.
bool EyeCapsule::contains(const EyeCapsule& other) const {
  return std::max(distanceTo(*this, other.eye), distanceTo(*this, other.eye + other.way)) + other.radius_m <= radius_m;
}

EyeCapsule hullOf(std::span<const EyeCapsule> parts) {
  EyeCapsule hull{parts.front().eye, parts.back().eye + parts.back().way - parts.front().eye, 0};
  for (const EyeCapsule& part : parts)
    hull.radius_m = std::max(
        hull.radius_m, std::max(distanceTo(hull, part.eye), distanceTo(hull, part.eye + part.way)) + part.radius_m);
  return hull;
}

// As in region.cpp: on a chord between two times the distance is largest at an end, and a curve leaves its chord by at
// most h^2 / 8 times its largest acceleration.
EyeCapsule capsuleOf(const ExpectedMotion& motion, Time begin, Time end) {
  constexpr int64_t kStep_us = 20'000, kMaxSteps = 16;
  const glm::dvec3 first = motion.at(begin).eye;
  EyeCapsule capsule{first, motion.at(end).eye - first, 0};
  double farthest_m = 0, max_bend_m = 0;
  Time time = begin;
  const auto advanceTo = [&](Time next) {
    const double h = (next - time).toSeconds();
    max_bend_m = std::max(max_bend_m, h * h / 8 * motion.maxAcceleration(time, next));
    farthest_m = std::max(farthest_m, distanceTo(capsule, motion.at(next).eye));
    time = next;
  };
  const int64_t steps = std::clamp<int64_t>(((end - begin).us + kStep_us - 1) / kStep_us, 1, kMaxSteps);
  for (int64_t i = 1; i <= steps; ++i) {
    const Time next = timeBetween(begin, end, i, steps);
    for (auto corner = motion.nextCorner(time); corner && *corner < next; corner = motion.nextCorner(time))
      advanceTo(*corner);
    advanceTo(next);
  }
  capsule.radius_m = farthest_m + max_bend_m;
  return capsule;
}

}  // namespace foreland::server
