// Which of the jumps that a viewer announces are taken for jumps. Each means a keyframe from nothing, so a viewer may
// announce a few at once and then one a second, by the server's clock; what it announces beyond that is a pose like any
// other, and a jump if it is recognised as one (proto/space/jump.h). One owner.
#pragma once

#include <algorithm>
#include <optional>

#include "base/time.h"

namespace foreland::server {

class AnnouncedJumps {
 public:
  static constexpr int64_t kAtOnce = 4;
  static constexpr Duration kEvery = Duration::seconds(1);

  // Whether a jump that is announced at `now` is taken for one. Times do not decrease.
  bool take(Time now) {
    const Time paid_until = std::max(paid_until_.value_or(now), now) + kEvery;
    if (paid_until - now > kEvery * kAtOnce) return false;
    paid_until_ = paid_until;
    return true;
  }

 private:
  std::optional<Time> paid_until_;  // by what was taken so far
};

}  // namespace foreland::server
