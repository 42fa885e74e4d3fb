// What the errors of predictions may cost a viewer whose poses are hard to predict. A keyframe's region holds the
// expected motion around its pose, which a known path needs as well, and what predictions were off by of late. For a
// camera that turns fast and irregularly the latter would make sections several times as large, and so late that
// nothing is gained. So a section may be kMax times as large as without errors; beyond, its tolerance is raised, up to
// kCoarsest times, and only then the share of errors is reduced. The header states the tolerance and the region that
// is left, and the client counts the frames outside of it.
//
// Both follow the sizes of some of the keyframes, and hold for the next ones as far as these are alike. Where they are
// not, the section itself grows or shrinks, which is noticed for nothing. Where the errors outgrow what was observed,
// sections are measured before one is sent. One owner (a session).
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
  static constexpr double kMax = 1.4;        // nodes of a section over those that it has without errors
  static constexpr double kCoarsest = 4;     // times the wanted tolerance
  static constexpr double kNodePower = 0.9;  // nodes fall as tolerance^-0.9, or faster
  static constexpr uint32_t kOften = 8, kSeldom = 96;

  // What is left of the region.
  Region of(const RegionParts& parts) const;
  // The same as a share of the whole, 0 to 1: the less of its radius and its angle.
  double shareOf(const RegionParts& parts) const;
  // How many times the wanted tolerance the next section may have, 1 to kCoarsest.
  double coarser() const { return coarser_; }

  // Before a keyframe: raises a reduced share where what was observed leaves room for more, reduces it until a
  // tolerance of kCoarsest makes the section small enough, and chooses the tolerance. `nodesOf(region, most)` gives the
  // nodes of the section for a region at one tolerance, or nothing if there are more than `most`. Cost: nothing as long
  // as the errors are small by what was observed, or as large; else `nodesOf` without errors, and once for each try,
  // seldom more than three, with at most kMeasured times as many nodes. What `nodesOf` is off by changes share and
  // tolerance, which the next keyframes correct, and no guarantee.
  template <class NodesOf>
  void fit(const RegionParts& parts, const NodesOf& nodesOf);

  // After each keyframe, once, with the nodes of its section. True if it is to be observed, which costs a sample of
  // it: the first, each whose section is an eighth larger or smaller than the last one observed, and
  // otherwise after kSeldom more at the latest, or kOften while errors take much, and at the earliest after half.
  [[nodiscard]] bool isDue(size_t nodes);
  // Of a keyframe: its region's parts, the nodes of its section, and those of one without errors at its tolerance.
  void observe(const RegionParts& parts, size_t nodes, size_t without_errors);

  double share() const { return share_; }  // of errors, 0 to 1

 private:
  // Of the section at the wanted tolerance, over that without errors: the most, and what the share is chosen for, since
  // sections differ.
  static constexpr double kMost = 5, kAim = 4.5, kMeasured = 7;
  static constexpr double kLeast = 1.0 / 1024;  // share of errors; they are left out where it would be less

  Region errorsOf(const RegionParts& parts) const;
  // What errors add to a section, as a share of what it has without, if that grows as their radius and angle.
  double expectedExcess(const RegionParts& parts) const;
  // Whether what was observed tells what errors add now.
  bool isForeseen(double excess) const;
  static double toleranceFor(double excess);

  double share_ = 1, coarser_ = 1;
  Region observed_;         // errors, the last time
  size_t nodes_ = 0;        // and the section's
  double excess_ = 0;       // of that over the section without errors, as a share of the latter
  uint32_t keyframes_ = 0;  // since then
  bool is_wide_ = false;
};

template <class NodesOf>
void RegionShare::fit(const RegionParts& parts, const NodesOf& nodesOf) {
  constexpr int kTries = 8;
  constexpr double kRise = 4, kMinRise = 1.1;
  const double reduced = share_;
  for (double rise = kRise; reduced < 1 && rise > kMinRise; rise = 1 + (rise - 1) / 2) {
    share_ = std::min(1.0, rise * reduced);
    if (expectedExcess(parts) <= kAim - 1) break;
    share_ = reduced;
  }
  coarser_ = toleranceFor(expectedExcess(parts));
  if (isForeseen(expectedExcess(parts))) return;
  const std::optional<size_t> alone = nodesOf(parts.withoutErrors(), std::numeric_limits<size_t>::max());
  if (!alone) return;
  const auto times = [&](double factor) { return static_cast<size_t>(factor * static_cast<double>(*alone)); };
  for (int tries = 0; tries < kTries; ++tries) {
    const std::optional<size_t> nodes = nodesOf(of(parts), times(kMeasured));
    observe(parts, nodes.value_or(times(kMeasured)), *alone);
    coarser_ = toleranceFor(expectedExcess(parts));
    if (nodes && *nodes <= times(kMost)) return;
  }
}

}  // namespace foreland::server
