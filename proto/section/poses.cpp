#include "proto/section/poses.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

namespace foreland::proto {

Result<PoseBlend> PoseBlend::create(const Epochs& scene, std::span<const uint32_t> epochs) {
  const auto refuse = [](const std::string& what) { return Error{ErrorCode::kMalformed, what}; };
  if (epochs.empty()) return PoseBlend();
  if (epochs.size() < 2 || epochs.size() > kMaxPoses)
    return refuse(std::to_string(epochs.size()) + " poses; a model has 2 to " + std::to_string(kMaxPoses));
  if (std::ranges::adjacent_find(epochs, std::greater_equal<>()) != epochs.end() || epochs.back() >= scene.size())
    return refuse("poses of no epochs, or out of order");
  if (scene.blend() == EpochBlend::kCatmullRom)
    return refuse("poses do not overshoot, as a Catmull-Rom blend may; blend epochs linearly or by a B-spline");
  PoseBlend blend;
  blend.poses_ = epochs.size();
  for (uint32_t epoch = 0; epoch < scene.size(); ++epoch) {
    const auto next = static_cast<size_t>(std::ranges::upper_bound(epochs, epoch) - epochs.begin());
    if (next == 0 || next == epochs.size()) {
      blend.pose_at_.push_back(next == 0 ? 0 : static_cast<double>(epochs.size() - 1));
      continue;
    }
    const Time from = scene[epochs[next - 1]].time, to = scene[epochs[next]].time;
    const double share = (scene[epoch].time - from).toSeconds() / (to - from).toSeconds();
    blend.pose_at_.push_back(static_cast<double>(next - 1) + share);
  }
  return blend;
}

std::vector<double> PoseBlend::weightsAt(const EpochWeights& epochs) const {
  if (isStill()) return {};
  std::vector<double> by_pose(poses_);
  for (uint32_t i = 0; i < epochs.count; ++i) {
    const double at = pose_at_[epochs.epoch[i]];
    const auto pose = static_cast<size_t>(at);
    const double share = at - std::floor(at);
    by_pose[pose] += epochs.weight[i] * (1 - share);
    if (share > 0) by_pose[pose + 1] += epochs.weight[i] * share;
  }
  by_pose.erase(by_pose.begin());
  return by_pose;
}

}  // namespace foreland::proto
