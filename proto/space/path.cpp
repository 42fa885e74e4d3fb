#include "proto/space/path.h"

#include <algorithm>
#include <string>

namespace foreland::proto {

Pose Path::at(Time t) const {
  if (t <= start) return poses.front();
  const int64_t offset = (t - start).us;
  const size_t last = poses.size() - 1;
  const size_t i = static_cast<size_t>(offset / step.us);
  if (i >= last) return poses.back();
  const double u = static_cast<double>(offset % step.us) / static_cast<double>(step.us);
  const glm::dvec3 p0 = poses[i == 0 ? 0 : i - 1].eye, p1 = poses[i].eye, p2 = poses[i + 1].eye,
                   p3 = poses[std::min(i + 2, last)].eye;
  const glm::dvec3 eye =
      p1 + 0.5 * u * ((p2 - p0) + u * ((2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3) + u * (3.0 * (p1 - p2) + p3 - p0)));
  return {eye, glm::slerp(poses[i].orientation, poses[i + 1].orientation, u)};
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
