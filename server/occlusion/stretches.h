// The eyes of several keyframe intervals at once, and what they see over the terrain: blocks are proved hidden for a
// stretch of intervals by one test. One owner.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "server/occlusion/eye_intervals.h"
#include "server/occlusion/horizon.h"

namespace foreland::server {

// Intervals begin to before end, which is a multiple of the stretch's length.
struct Stretch {
  int64_t begin = 0, end = 0;
  uint32_t keyframe = 0;  // for which it was found to hold, or made
  EyeSweep eyes;
  std::shared_ptr<Horizon> horizon;  // null without a grid, and until it is asked for
};

class Stretches {
 public:
  static constexpr std::array<uint32_t, 2> kLengthLog2{4, 3};  // the longest first
  static constexpr size_t kLengths = kLengthLog2.size();

  // Both must outlive it; `grid` may be null.
  Stretches(const EyeIntervals& intervals, const HorizonGrid* grid) : intervals_(intervals), grid_(grid) {}

  // The stretch of a length that holds an interval; null if not all of its eyes are expected. Made anew if they are
  // expected elsewhere or in far less room. Valid until the next keyframe.
  Stretch* at(size_t length, int64_t interval, uint32_t keyframe);
  // The intervals in which the keyframe is shown. Valid until the next keyframe.
  Stretch& now(uint32_t keyframe);
  // With bins of this width.
  Horizon& horizonOf(Stretch& stretch, double bin);

  void dropPast();
  void clear();
  size_t bytes() const;

 private:
  static constexpr size_t kHeld = 16;  // of a length

  std::shared_ptr<Horizon> sightOf(std::span<const EyeSweep> parts, double radius_m, size_t length) const;
  void drop(Stretch& stretch);
  size_t collect(int64_t begin, int64_t end);

  const EyeIntervals& intervals_;
  const HorizonGrid* grid_;
  std::array<std::array<Stretch, kHeld>, kLengths> held_;
  Stretch now_;
  std::array<EyeSweep, 1u << kLengthLog2[0]> parts_;  // of a stretch
  std::vector<std::shared_ptr<Horizon>> spare_;       // their memory is used again
};

}  // namespace foreland::server
