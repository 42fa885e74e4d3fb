// Per-node morph timing (S 3.5): how long a node that is added or removed takes for it, on the terrain or on one
// object, in that surface's own frame. Lengths are in intervals, the time that one mesh is shown for; no change takes
// less than one, unless it is a jump.
//
// For the first mesh, and the first one after a restart from nothing, every change is a jump: both ends show the whole
// section. Later,
//
//   keyframe   one interval for every node; b-splines likewise, from each section to the next
//   geomorph   a time that shrinks with how fast the node moves before the eye. Its rate is that of a change at rest, plus
//              shares for the speed at which the eye nears it and turns,
//                  1 / seconds = 1 / kAtRest_s + v / (kMoved r) + angular_speed / kTurned_rad
//              so that the change is over before the eye has come nearer by kMoved of the distance r: an error that is
//              corrected late is then at most 1 / (1 - kMoved) of what it was when the keyframe wanted it corrected.
//              0, a jump, for what cannot be seen from anywhere in the region that the keyframe's error guarantee
//              covers: it was added or removed because of the frustum or the back faces, or nobody can tell.
// Value; any thread; O(1) a node.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/time.h"
#include "client/mesh/weights/blend.h"
#include "proto/refine/metric/frustum.h"
#include "proto/refine/metric/motion_bound.h"
#include "proto/section/epochs.h"
#include "proto/space/view.h"

namespace foreland::client {

// How fast the eye moves and turns. The speed is in the units of the frame at hand, a second.
struct Motion {
  double metres_per_s = 0, radians_per_s = 0;

  static Motion between(const proto::View& from, const proto::View& to, Duration time) {
    const double s = time.toSeconds();
    if (!(s > 0)) return {};
    return {glm::distance(from.pose.eye, to.pose.eye) / s,
            proto::angleBetween(from.pose.orientation, to.pose.orientation) / s};
  }
};

// The mesh that is about to be made. The view and the motion are in the scene's frame.
struct MeshSpan {
  Blend blend = Blend::kKeyframe;
  proto::View from;  // of the keyframe that it begins with
  Motion motion;
  double seconds = 0;                           // how long it is shown
  bool is_first = false;                        // no mesh comes before it
  std::array<proto::EpochWeights, 2> ground{};  // that it shows at its ends, in scenes that change in time
};

class MorphTiming {
 public:
  static constexpr double kAtRest_s = 1;  // "approximately a second" (S)
  static constexpr double kMoved = 0.125, kTurned_rad = 0.25;

  // `from` and `metres_per_s` are span.from and span.motion.metres_per_s in the frame in which spheres will be given.
  MorphTiming(const MeshSpan& span, const proto::View& from, double metres_per_s)
      : span_(span),
        eye_(from.pose.eye),
        region_radius_(from.region_radius_m),
        metres_per_s_(metres_per_s),
        frustum_(from, 0) {}

  // Whether every node takes equally long, so that intervals() ignores its arguments.
  bool isUniform() const { return span_.is_first || span_.blend != Blend::kGeomorph; }
  // How many intervals a node takes whose support lies within the sphere; 0 for a jump.
  double intervals(const glm::dvec3& centre, double radius_m) const {
    if (isUniform()) return span_.is_first ? 0 : 1;
    if (!meetsFrustum(centre, radius_m)) return 0;
    const double r = std::max(glm::distance(centre, eye_), 1e-3);
    const double per_s = 1 / kAtRest_s + metres_per_s_ / (kMoved * r) + span_.motion.radians_per_s / kTurned_rad;
    return std::max(1.0, 1 / (per_s * std::max(span_.seconds, 1e-3)));
  }

 private:
  bool meetsFrustum(const glm::dvec3& centre, double radius_m) const {
    const glm::dvec3 p = centre - eye_;
    return frustum_.sideDistance(frustum_.toView(p.x, p.y, p.z)) + radius_m + region_radius_ >= 0;
  }

  MeshSpan span_;
  glm::dvec3 eye_;
  double region_radius_, metres_per_s_;
  proto::Frustum frustum_;
};

}  // namespace foreland::client
