#include "proto/space/path.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <string>

namespace foreland::proto {

namespace {

// Catmull-Rom between poses i and i + 1: the eye is start + (first u + second u^2 + third u^3) / 2, u from 0 to 1.
struct Cubic {
  glm::dvec3 start, first, second, third;
};

Cubic cubicOf(const std::vector<Pose>& poses, size_t i) {
  const glm::dvec3 p0 = poses[i == 0 ? 0 : i - 1].eye, p1 = poses[i].eye, p2 = poses[i + 1].eye,
                   p3 = poses[std::min(i + 2, poses.size() - 1)].eye;
  return {p1, p2 - p0, 2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3, 3.0 * (p1 - p2) + p3 - p0};
}

}  // namespace

Pose Path::at(Time t) const {
  if (t <= start) return poses.front();
  const int64_t offset = (t - start).us;
  const size_t i = static_cast<size_t>(offset / step.us);
  if (i >= poses.size() - 1) return poses.back();
  const double u = static_cast<double>(offset % step.us) / static_cast<double>(step.us);
  const Cubic c = cubicOf(poses, i);
  const glm::dvec3 eye = c.start + 0.5 * u * (c.first + u * (c.second + u * c.third));
  return {eye, glm::slerp(poses[i].orientation, poses[i + 1].orientation, u)};
}

std::optional<Time> Path::nextPoseTime(Time t) const {
  if (t < start) return start;
  const int64_t i = (t - start).us / step.us + 1;
  if (i >= static_cast<int64_t>(poses.size())) return std::nullopt;
  return start + step * i;
}

double Path::maxAcceleration(Time begin, Time end) const {
  if (begin < start) return 0;
  const size_t i = static_cast<size_t>((begin - start).us / step.us);
  if (i >= poses.size() - 1) return 0;
  const Cubic c = cubicOf(poses, i);
  const Time from = start + step * static_cast<int64_t>(i);
  // Linear in time, so it is largest at an end.
  const auto at = [&](Time t) {
    return glm::length(c.second + 3 * ((t - from).toSeconds() / step.toSeconds()) * c.third);
  };
  return std::max(at(begin), at(end)) / (step.toSeconds() * step.toSeconds());
}

Status Path::validate() const {
  const auto malformed = [](const std::string& what) { return Error{ErrorCode::kMalformed, "path: " + what}; };
  if (poses.size() < 2 || poses.size() > kMaxPoses)
    return malformed(std::to_string(poses.size()) + " poses; 2 to " + std::to_string(kMaxPoses) + " are allowed");
  if (step < Duration::milliseconds(1) || step > Duration::milliseconds(60'000))
    return malformed("step outside 1 ms to 60 s");
  for (size_t i = 0; i < poses.size(); ++i)
    if (!isUsable(poses[i]))
      return malformed("pose " + std::to_string(i) + " is not finite, too far away or not a rotation");
  return {};
}

}  // namespace foreland::proto
