// How long a node may take to come or go (S 3.5): what the clocks of Morphs are set by, for the terrain or for one
// object, in its own frame. Lengths are in intervals of the meshes, of which no change takes less than one.
//
//   keyframe   one interval, whatever it is
//   geomorph   seconds scaled by how fast the node moves before the eye: its speed is that of a change at rest, plus
//              shares of how fast the eye nears it and turns,
//                  1 / length = 1 / kAtRest_s + v / (kMoved r) + turn / kTurned_rad
//              so that it is over before the eye has come nearer by kMoved of the distance r: an error that is late is
//              then no more than 1 / (1 - kMoved) of what it was when it was due.
//              0 for the first section there is, and for what cannot be seen where the mesh begins, from anywhere that
//              keyframe's promise holds for: then the change is the frustum's or the back faces', or might as well be.
// Value; any thread; O(1) a node.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/time.h"
#include "client/blend.h"
#include "proto/refine/frustum.h"
#include "proto/refine/motion_bound.h"
#include "proto/space/view.h"

namespace foreland::client {

// How fast the eye moves, in any frame of the scene's size.
struct Motion {
  double metres_per_s = 0, radians_per_s = 0;

  static Motion between(const proto::View& from, const proto::View& to, Duration time) {
    const double s = time.toSeconds();
    if (!(s > 0)) return {};
    return {glm::distance(from.pose.eye, to.pose.eye) / s,
            proto::angleBetween(from.pose.orientation, to.pose.orientation) / s};
  }
};

// A mesh to be: where it begins and how it blends. The view and the motion are in the scene's frame.
struct MeshSpan {
  Blend blend = Blend::kKeyframe;
  proto::View from;
  Motion motion;
  double seconds = 0;     // that it lasts
  bool is_first = false;  // there is none before it
};

class MorphClock {
 public:
  static constexpr double kAtRest_s = 1;  // "approximately a second" (S)
  static constexpr double kMoved = 0.125, kTurned_rad = 0.25;

  // `from` and `metres_per_s` in the frame of the spheres, whatever `span` has.
  MorphClock(const MeshSpan& span, const proto::View& from, double metres_per_s)
      : span_(span), eye_(from.pose.eye), ball_(from.region_radius_m), metres_per_s_(metres_per_s), frustum_(from, 0) {}

  // Whether it asks for spheres at all.
  bool isEven() const { return span_.blend == Blend::kKeyframe; }
  // The support lies within the sphere.
  double intervals(const glm::dvec3& centre, double radius_m) const {
    if (isEven()) return 1;
    if (span_.is_first || !meetsFrustum(centre, radius_m)) return 0;
    const double r = std::max(glm::distance(centre, eye_), 1e-3);
    const double per_s = 1 / kAtRest_s + metres_per_s_ / (kMoved * r) + span_.motion.radians_per_s / kTurned_rad;
    return std::max(1.0, 1 / (per_s * std::max(span_.seconds, 1e-3)));
  }

 private:
  bool meetsFrustum(const glm::dvec3& centre, double radius_m) const {
    const glm::dvec3 p = centre - eye_;
    return frustum_.sideDistance(frustum_.place(p.x, p.y, p.z)) + radius_m + ball_ >= 0;
  }

  MeshSpan span_;
  glm::dvec3 eye_;
  double ball_, metres_per_s_;
  proto::Frustum frustum_;
};

}  // namespace foreland::client
