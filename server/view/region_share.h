// How much of a keyframe's region a viewer gets whose poses are hard to predict. The region holds the expected motion
// around the keyframe and what predictions were off by of late. For a camera that turns fast and irregularly it would
// make sections several times as large as the pose alone needs, and so late that nothing is gained. So a section may be
// kMost times as large as the pose alone needs; of a larger one the share of prediction errors is reduced first, then
// that of the motion. The header states the region that is left, and the client counts the frames outside of it.
//
// The share follows the sizes of some of the keyframes, so it holds for the next ones as far as these are alike. Where
// they are not, the section itself grows or shrinks, which is noticed for nothing.
// One owner (a session).
#pragma once

#include <cstddef>
#include <cstdint>

#include "server/view/region.h"

namespace foreland::server {

class RegionShare {
 public:
  static constexpr double kMost = 1.5;  // nodes of a section over those that the pose alone needs
  static constexpr uint32_t kOften = 8, kSeldom = 96;

  // What is left of the region that holds the motion and may be off by `error`.
  Region of(const Region& motion, const Region& error) const;

  // To be called once for each keyframe, with the nodes of its section. True if it is to be observed, which costs a
  // refinement from scratch: the first, each whose section is an eighth larger or smaller than the last one observed,
  // and otherwise after kSeldom more at the latest, or kOften while the region is wide, and at the earliest after half.
  [[nodiscard]] bool isDue(size_t nodes);
  // Of the last keyframe: the nodes of its section, and of one for its pose alone.
  void observe(size_t nodes, size_t pose_alone);

  double share() const { return share_; }  // 0 to 1

 private:
  double share_ = 1;
  bool is_wide_ = false;
  size_t nodes_ = 0;        // when it was observed last
  uint32_t keyframes_ = 0;  // since then
};

}  // namespace foreland::server
