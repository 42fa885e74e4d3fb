// How a server that stops migrates its viewers. Each is asked to connect again, is led to another server by whatever
// stands before the two (a proxy, a name), and resumes there from the section that it holds. Values without a clock, so
// that the server's I/O thread, the pool's simulation and the virtual world of tests keep to the same rules.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>

#include "base/time.h"

namespace foreland::server {

// When viewers are asked: one after another, so that the other servers need not resume all of them in one instant.
class MigrationTurns {
 public:
  // Half of that or less is what one worker takes for a viewer that resumes.
  static constexpr Duration kBetweenViewers = Duration::milliseconds(40);

  // All of them are asked within half of `most`, and faster if they are few.
  MigrationTurns(size_t viewers, Time begin, Duration most)
      : viewers_(static_cast<int64_t>(viewers)),
        begin_(begin),
        spread_(std::min(Duration{most.us / 2}, kBetweenViewers * viewers_)) {}

  // Of the one who is asked after `asked` others. Those that came meanwhile are asked last.
  Time timeOf(size_t asked) const {
    const auto turn = static_cast<int64_t>(asked);
    return turn >= viewers_ ? begin_ + spread_ : begin_ + Duration{spread_.us * turn / viewers_};
  }

 private:
  int64_t viewers_;
  Time begin_;
  Duration spread_;
};

// When one viewer leaves: as soon as all that was made for it has been sent. That is right after its next keyframe, and
// so the other server has nearly a whole interval until the one after it is due. One owner.
class Migration {
 public:
  static constexpr Duration kLongest = Duration::seconds(1);  // to the next keyframe

  void ask(Time now) { asked_at_ = asked_at_.value_or(now); }
  bool isAsked() const { return asked_at_.has_value(); }
  // Whether it leaves when all has just been sent.
  bool leavesOnceSent() const { return isAsked(); }
  // Whether it leaves at `now`, whatever waits: when no keyframe has come for too long, and at once if it has not said
  // what it wants (`has_greeted`).
  bool isOverdue(Time now, bool has_greeted) const { return isAsked() && (!has_greeted || now >= latest()); }
  // It must have been asked.
  Time latest() const { return *asked_at_ + kLongest; }

 private:
  std::optional<Time> asked_at_;
};

}  // namespace foreland::server
