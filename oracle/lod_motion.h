// What the change of detail alone moves on the screen: the drawn vertices of a mesh at two weights, seen by one camera.
// The less at a time, the less it shows (THEORY section 3: with keyframes at most 2 tau over the frames between two).
// Pure; any thread; O(vertices).
#pragma once

#include <vector>

#include "client/mesh/patch/keyframe_mesh.h"
#include "oracle/stretch.h"
#include "proto/space/pose.h"

namespace foreland::oracle {

struct WeightStep {
  double before = 0, after = 1;
};

// Appends the pixels by which each vertex moves that has two different positions and is seen at both weights, more than
// 1 m in front of the eye; vertices of the terrain and of objects alike. Returns how many vertices are so seen, still
// ones included.
size_t collectLodMotion(const client::KeyframeMesh& mesh, WeightStep step, const proto::Pose& pose,
                        const proto::Lens& lens, std::vector<double>& out_px, const Stretch& stretch = {});

}  // namespace foreland::oracle
