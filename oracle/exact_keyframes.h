// What keyframes would have been, had their poses been known; the last few are kept. One owner.
#pragma once

#include <map>
#include <memory>

#include "oracle/flight_truth.h"
#include "proto/message/message.h"

namespace foreland::oracle {

class ExactKeyframes {
 public:
  using Mesh = std::shared_ptr<const client::KeyframeMesh>;

  // The section of the keyframe `header` for the true pose at its time, with the region that the keyframe has.
  Mesh at(const SectionAt& section_at, const proto::Pose& pose, const proto::Lens& lens,
          const proto::KeyframeHeader& header) {
    Mesh& mesh = meshes_[header.index];
    if (!mesh)
      mesh = section_at({.pose = pose,
                         .lens = lens,
                         .tau_px = header.tau_px,
                         .region_radius_m = header.region_radius_m,
                         .region_angle_rad = header.region_angle_rad,
                         .scene_time = header.scene_time});
    const Mesh result = mesh;
    while (meshes_.size() > kKept) meshes_.erase(meshes_.begin());
    return result;
  }

 private:
  static constexpr size_t kKept = 3;
  std::map<uint32_t, Mesh> meshes_;
};

}  // namespace foreland::oracle
