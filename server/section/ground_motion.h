// How far scene time may go from one keyframe to the next in a scene whose blend of epochs is cubic
// (proto::EpochBlend). Frames between two keyframes show mix(from, to, weight), the ground at the scene time between is
// curved in time: over a step of h seconds the two differ by a h^2 / 8 at most, a being the largest acceleration on the
// way, which at any place is largest at an epoch. A step is short enough if that is seen as no more than
// proto::kMotionShare of the tolerance from anywhere in the keyframe's region. The rest of the tolerance is the
// section's (proto::sectionTolerance).
//
// Ground and objects that move, by it or in themselves, are put together to some thousand spheres, each with the
// accelerations of what it holds, by the interval between two epochs. Immutable; any thread. Construction is
// O(offsets).
#pragma once

#include <vector>

#include "proto/space/view.h"
#include "server/section/hierarchy.h"

namespace foreland::server {

class GroundMotion {
 public:
  // `hierarchy` must outlive it; its blend is not linear.
  explicit GroundMotion(const Hierarchy& hierarchy);

  // The scene time nearest to `wanted` that a keyframe for `view` may have after one of `from`. The view's tolerance is
  // that of frames. O(spheres).
  Time towards(Time from, Time wanted, const proto::View& view) const;

 private:
  struct Mover {
    glm::dvec3 centre{0};
    double radius_m = 0;
    std::vector<float> acceleration;  // largest between an epoch and the next, metres a second^2, rounded up
  };
  Mover& moverOf(proto::NodeId v);
  void add(proto::NodeId v, std::span<const int32_t> quanta);
  void addObjects();
  void addPoses(Mover& mover, size_t object) const;
  void raise(Mover& mover, std::span<const int32_t> quanta, double off_quanta) const;
  // The longest steps between an epoch and the next, seconds.
  std::vector<double> longestSteps(const proto::View& view) const;

  const Hierarchy& hierarchy_;
  std::vector<proto::EpochCurve> curves_;
  uint32_t side_ = 1, columns_ = 1;  // of the squares of ground, samples; squares in a row
  std::vector<Mover> movers_;        // squares, then objects
};

}  // namespace foreland::server
