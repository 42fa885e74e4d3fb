// Which mesh is shown at a time: the end of the time line (timeline.h) that draws. A host that makes meshes in one
// place and draws them in another (the page: a worker and its drawing thread) has a Schedule of its own where it draws,
// to which it hands the intervals that the time line adds. Interval is plain data and can be copied byte for byte. One
// owner; times are the client's clock.
#pragma once

#include <cstdint>
#include <deque>
#include <limits>
#include <optional>
#include <type_traits>

#include "base/time.h"
#include "client/mesh/patch/keyframe_mesh.h"
#include "proto/message/compact.h"

namespace foreland::client {

// What is shown from `begin` to `end`: the mesh between two keyframes, or of more.
struct Interval {
  uint32_t version = 0;  // of the mesh; ascends, never 0
  Time begin, end;
  proto::KeyframeHeader from, to;
  EarlierKeyframes earlier{};

  // The times on the path that it shows at its beginning and its end.
  Time shownFrom() const { return from.time - earlier.from_age; }
  Time shownTo() const { return to.time - earlier.to_age; }
};
static_assert(std::is_trivially_copyable_v<Interval>);

class Schedule {
 public:
  static constexpr Duration kShortestBlend = Duration::milliseconds(50);
  static constexpr uint32_t kAllReady = std::numeric_limits<uint32_t>::max();

  // `interval` follows those that were added before, which may end late by now, or none if they are to be replaced
  // (dropBefore).
  void add(const Interval& interval);
  // Meshes before this version will not be shown any more. The one that is shown stays until another one is ready.
  void dropBefore(uint32_t version);
  void popFront() { intervals_.pop_front(); }
  // Nothing is shown until an interval is added.
  void clear();

  size_t size() const { return intervals_.size(); }
  const Interval& front() const { return intervals_.front(); }
  const Interval& back() const { return intervals_.back(); }

  struct Shown {
    const Interval* interval = nullptr;  // nullptr if there is none; valid until the next call of a member
    double weight = 0;                   // of the interval's `to`, from 0 to 1
    Time shown_time;                     // t_d: the time on the path that is shown
    bool is_over = false;                // the interval has ended and no other follows
  };
  // What to show at `now`, which must not decrease, if only the mesh of version `ready` can be shown, and the one that
  // was shown last. Drops intervals that have ended. One whose time has come, but which is not ready, begins when it
  // is: what is shown never jumps. `coming` is being made ready, so it is not dropped even if a later one's time has
  // come.
  Shown at(Time now, uint32_t ready = kAllReady, uint32_t coming = 0);
  // The version to make ready next, after at(); 0 if there is none.
  uint32_t next() const;

 private:
  void dropUntil(Time now, uint32_t ready, uint32_t coming);
  bool isReady(size_t i, uint32_t ready) const {
    return ready == kAllReady || intervals_[i].version == ready || intervals_[i].version == shown_;
  }
  void postpone(size_t first, Time begin);

  std::deque<Interval> intervals_;
  std::optional<Time> postponed_until_;  // no interval that is added begins before; if some were late
  uint32_t shown_ = 0;                   // version of what at() returned last
};

}  // namespace foreland::client
