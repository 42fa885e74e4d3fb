// When a session reads ahead what its next keyframes will need of a scene that may be larger than memory. Where all of
// it is in memory, reading ahead is of no use: after a prefetch that read nothing from the disk the next one comes
// twice as late, up to kMax, and as soon as anything had to be read they are kMin apart again. One owner.
#pragma once

#include <algorithm>
#include <cstdint>

#include "base/time.h"

namespace foreland::server {

class PrefetchPace {
 public:
  static constexpr Duration kMin = Duration::milliseconds(500), kMax = kMin * 32;

  // The time of the next prefetch.
  Time next() const { return next_; }
  void begun(Time now) { next_ = now + every_; }
  // It is done, and has read so many pages from the disk.
  void ended(Time now, uint64_t pages_read) {
    every_ = pages_read > 0 ? kMin : std::min(every_ * 2, kMax);
    next_ = now + every_;
  }
  // A keyframe had to wait for so many pages.
  void keyframeRead(Time now, uint64_t pages_read) {
    if (pages_read == 0) return;
    every_ = kMin;
    next_ = std::min(next_, now + every_);
  }

 private:
  Duration every_ = kMin;
  Time next_;
};

}  // namespace foreland::server
