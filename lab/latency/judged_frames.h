// Which frames of a flight are put before the oracle: ten of the 60 a second, or fewer of these. Value types; pure.
//
// Keyframes follow each other after 6, 12 or 30 frames. A stride that shares a factor with these would see the same few
// weights between two keyframes for the whole flight, so a frame is taken from each run of six, at a phase that moves
// on with every run. Of as many runs as a lower rate leaves one of, the golden ratio tells which: its multiples are
// spread evenly, whatever the interval is, so the frames of a lower rate are some of those of a higher one and fall on
// all phases that ten a second do, equally often in the long run.
#pragma once

#include <cstdint>

#include "base/result.h"

namespace foreland::lab {

class JudgedFrames {
 public:
  static constexpr double kMax_hz = 10, kMin_hz = 0.1;

  // Ten a second, or a whole part of it. An Error names a rate that is none.
  static Result<JudgedFrames> atRate(double hz);

  constexpr JudgedFrames() = default;
  constexpr explicit JudgedFrames(uint32_t one_in) : one_in_(one_in) {}

  double hz() const { return kMax_hz / one_in_; }

  // Frames are counted from the flight's beginning.
  constexpr bool has(uint64_t frame) const {
    const uint64_t run = frame / kRun;
    if (frame % kRun != (kRun - 1) * run % kRun) return false;
    const uint64_t turn = static_cast<uint32_t>(run / one_in_ * kGoldenRatio);
    return run % one_in_ == turn * one_in_ >> 32;
  }

 private:
  static constexpr uint64_t kRun = 6;
  static constexpr uint32_t kGoldenRatio = 2'654'435'769;  // its fraction, of 2^32

  uint32_t one_in_ = 1;  // of the runs
};

}  // namespace foreland::lab
