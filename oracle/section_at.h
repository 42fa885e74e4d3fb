// How the oracle asks for a section: it must not know the code that computes one.
#pragma once

#include <functional>
#include <memory>

#include "base/time.h"
#include "client/mesh/patch/keyframe_mesh.h"
#include "proto/space/pose.h"

namespace foreland::oracle {

// What a section is to be computed for. The region is that in which a keyframe guarantees its tolerance
// (proto::KeyframeHeader); a section of a view alone has none.
struct SectionRequest {
  proto::Pose pose;
  proto::Lens lens;
  double tau_px = 1;
  double region_radius_m = 0;
  double region_angle_rad = 0;
  Time scene_time{};  // of the ground, in scenes with epochs; before the first one is at it
};

// The mesh of the section computed from scratch for exactly that, both positions equal. One owner.
using SectionAt = std::function<std::shared_ptr<const client::KeyframeMesh>(const SectionRequest&)>;

}  // namespace foreland::oracle
