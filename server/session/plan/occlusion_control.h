// Whether the keyframes of one viewer leave out what is hidden, where that is left to the server (Occlusion::kAuto):
// as long as the workers have room for it, and it is worth what it takes.
//
// The viewer is judged, not its proofs: from time to time the section is compared with the one that nothing would be
// left out of. A comparison costs time, too, so it is due once the proofs since the last one have taken ten times as
// much. Where little is left out the viewer does without, for 10 s, and each time that it turns out so again for twice
// as long. Where the workers have no room, those do without for whom the proofs take longer than what they leave out
// would.
//
// Plain data; reads no clock. One owner (a session).
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/time.h"

namespace foreland::server {

class OcclusionControl {
 public:
  // kNone: nothing is left out; kFading: what is turns visible, part by part; kAll: what is hidden is left out.
  enum class Effort : uint8_t { kNone, kFading, kAll };

  // The rank of the viewer with this number: evenly spread over 0 to 1, whichever viewers stay.
  static double rankOf(uint64_t number);

  // For the keyframe at `now`, from nothing or not. `share` is that of the viewers whose keyframes the workers have
  // room to leave something out of, from 0 to 1; `rank` is this viewer's among them, evenly spread over 0 to 1.
  Effort next(Time now, double share, double rank, bool is_from_nothing);
  // After a keyframe: the times that it took in all, and for what is hidden; and whether anything is left that fades.
  void observe(Duration all, Duration occlusion, bool hides_anything);

  // Whether the section is to be compared, which takes about `cost`.
  bool isComparisonDue(Time now, Duration cost) const;
  // A section of `held` nodes has so many with what is hidden; more than that if only a lower bound is known.
  void compared(Time now, size_t held, size_t with_hidden);

  Effort effort() const { return effort_; }
  // As last compared: nodes left out for each that is held; 0 if unknown.
  double leftOut() const { return effort_ == Effort::kNone ? 0 : left_out_; }
  uint64_t timesShed() const { return times_shed_; }            // for want of room
  uint64_t timesWorthless() const { return times_worthless_; }  // since little was left out

 private:
  bool isCheap() const;
  bool isWanted(Time now, double share, double rank) const;

  Effort effort_ = Effort::kNone;
  bool hides_anything_ = false;
  double left_out_ = 0;
  double all_s_ = 0, occlusion_s_ = 0;  // of a keyframe, smoothed
  double spent_s_ = 0;                  // on proofs since the last comparison
  Time rests_until_;                    // since little was left out
  Time began_;                          // the effort kAll
  Duration rest_{};                     // the next one
  uint64_t times_shed_ = 0, times_worthless_ = 0;
};

}  // namespace foreland::server
