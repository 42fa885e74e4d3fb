// How much of a keyframe's region a viewer gets whose poses are hard to predict. The region holds the expected motion
// around the keyframe and what predictions were off by of late. For a camera that turns fast and irregularly it would
// make sections several times as large as the pose alone needs, and so late that nothing is gained. So a section may be
// kMax times as large as the pose alone needs; of a larger one the share of prediction errors is reduced first, then
// that of the motion. The header states the region that is left, and the client counts the frames outside of it.
//
// The share follows the sizes of some of the keyframes, and holds for the next ones as far as these are alike. Where
// they are not, the section itself grows or shrinks, which is noticed for nothing. Where the region outgrows what was
// observed, because the camera begins to turn, say, sections are measured before one is sent. One owner (a session).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "server/view/region.h"

namespace foreland::server {

class RegionShare {
 public:
  static constexpr double kMax = 1.5;  // nodes of a section over those that the pose alone needs
  static constexpr uint32_t kOften = 8, kSeldom = 96;

  // What is left of the region.
  Region of(const RegionParts& parts) const;
  // The same as a share of the whole, 0 to 1: the less of its radius and its angle.
  double shareOf(const RegionParts& parts) const;

  // Before a keyframe: raises a reduced share where what was observed leaves room for more, and reduces it until the
  // section is within kMax. `nodesOf(region, most)` gives the nodes of the section for a region, or nothing if there
  // are more than `most`. Cost: nothing as long as the region is small by what was observed; else `nodesOf` for the
  // pose alone, and once for each try, seldom more than three, with at most 2.5 times as many nodes. What `nodesOf` is
  // off by changes the share, which the next keyframes correct, and no guarantee.
  template <class NodesOf>
  void fit(const RegionParts& parts, const NodesOf& nodesOf);

  // After each keyframe, once, with the nodes of its section. True if it is to be observed, which costs a sample of
  // it: the first, each whose section is an eighth larger or smaller than the last one observed, and
  // otherwise after kSeldom more at the latest, or kOften while the region is wide, and at the earliest after half.
  [[nodiscard]] bool isDue(size_t nodes);
  // Of a keyframe: its region, the nodes of its section, and those of one for its pose alone.
  void observe(const Region& region, size_t nodes, size_t pose_alone);

  double share() const { return share_; }  // 0 to 1

 private:
  static constexpr double kAim = 1.35;  // what the share is chosen for: less than kMax, for sections differ

  // What the region adds to a section, as a share of what the pose alone needs, if that grows as its radius and angle.
  double expectedExcess(const Region& region) const;

  double share_ = 1;
  Region observed_;         // the last one
  size_t nodes_ = 0;        // and its section's
  double excess_ = 0;       // of that over the section of the pose alone, as a share of the latter
  uint32_t keyframes_ = 0;  // since then
  bool is_wide_ = false;
};

template <class NodesOf>
void RegionShare::fit(const RegionParts& parts, const NodesOf& nodesOf) {
  constexpr int kTries = 8;
  constexpr double kMeasured = 2.5;  // times the nodes for the pose alone
  constexpr double kRise = 4, kMinRise = 1.1, kSmall = 0.9 * (kMax - 1);
  const double reduced = share_;
  for (double rise = kRise; reduced < 1 && rise > kMinRise; rise = 1 + (rise - 1) / 2) {
    share_ = std::min(1.0, rise * reduced);
    if (expectedExcess(of(parts)) <= kAim - 1) break;
    share_ = reduced;
  }
  if (expectedExcess(of(parts)) <= kSmall) return;
  const std::optional<size_t> alone = nodesOf(Region{}, std::numeric_limits<size_t>::max());
  if (!alone) return;
  const auto times = [&](double factor) { return static_cast<size_t>(factor * static_cast<double>(*alone)); };
  for (int tries = 0; tries < kTries; ++tries) {
    const Region region = of(parts);
    const std::optional<size_t> nodes = nodesOf(region, times(kMeasured));
    observe(region, nodes.value_or(times(kMeasured)), *alone);
    if (nodes && *nodes <= times(kMax)) return;
  }
}

}  // namespace foreland::server
