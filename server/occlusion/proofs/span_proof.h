// How long something is proved to be hidden, span by span (path_spans.h), and when that is tried again.
//
// What is visible must be hidden for some intervals ahead to turn hidden, lest it flicker. Where a span shows it, it is
// not tried again before that span is past, and more and more seldom the longer it stays visible. What is hidden is
// renewed a little before the proof ends, so that proofs that end together are not renewed together.
//
// The test itself is the caller's: hides(PathSpan&, Towards). Times are numbers of intervals (eye_intervals.h). Plain
// functions on the caller's state; no clock.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "server/occlusion/proofs/eye_intervals.h"
#include "server/occlusion/proofs/path_spans.h"

namespace foreland::server {

struct SpanProof {
  int32_t until = 0;      // the last interval for which it is known to be hidden, if it is
  uint32_t keyframe = 0;  // when that was found out
  // The last interval in which no span hides it, as these are at a revision.
  int32_t open_until = std::numeric_limits<int32_t>::min();
  uint32_t revision = 0;
  uint8_t length = 1;    // of the span that was the last proof
  uint8_t lengths = 0;   // of all spans that are a part of the proof (PathSpans::Lengths)
  uint8_t failures = 0;  // tries in a row to prove it hidden
};

enum class Towards : uint8_t { kVisible, kHidden };  // what a test is to find out for

class SpanProver {
 public:
  static constexpr int64_t kSpread = 8;  // intervals over which proofs that end together are renewed
  struct Law {
    int64_t worth;           // intervals after a keyframe's for which it must be hidden to turn so
    int64_t rest = 0;        // intervals more until a visible one is tried again
    bool tries_last = true;  // whether one test of the last span tells most that are visible
  };

  // For a keyframe. `phase` is the proof's own: it spreads what is done now and then over the keyframes.
  SpanProver(const EyeIntervals& intervals, PathSpans& spans, const Law& law, uint32_t keyframe)
      : intervals_(intervals), spans_(spans), law_(law), keyframe_(keyframe) {}

  // Whether what is visible is hidden from now on; sets when it is to be reviewed.
  template <class Hides>
  bool turnsHidden(SpanProof& proof, int32_t& next, uint32_t phase, const Hides& hides) const;
  // Whether what is hidden is so still; sets when it is to be reviewed.
  template <class Hides>
  bool staysHidden(SpanProof& proof, int32_t& next, uint32_t phase, const Hides& hides) const;
  int64_t worth() const { return law_.worth; }

 private:
  static constexpr uint64_t kUpgradePeriod = 4;  // renewals, about, between two tries of a longer span
  static constexpr uint8_t kMaxFailures = 2;     // in a row that prolong the rest, to twice as much each

  template <class Hides>
  int64_t hiddenUntil(SpanProof& proof, uint32_t phase, int64_t first, int64_t last, Towards towards,
                      const Hides& hides) const;

  const EyeIntervals& intervals_;
  PathSpans& spans_;
  const Law law_;
  const uint32_t keyframe_;
};

// The last interval up to which it is proved to be hidden from `first` on; before `first` if it is not. Goes on to
// `last` at most, and to the end of the span of that.
template <class Hides>
int64_t SpanProver::hiddenUntil(SpanProof& proof, uint32_t phase, int64_t first, int64_t last, Towards towards,
                                const Hides& hides) const {
  while (first <= last) {
    size_t length = proof.length;
    if (length > 0 && (phase + static_cast<uint64_t>(first)) % kUpgradePeriod == 0) --length;
    const PathSpan* found = nullptr;
    for (; length < PathSpans::kLengths && !found; ++length)
      if (PathSpan* const span = spans_.at(length, first); span && hides(*span, towards)) {
        found = span;
        proof.length = static_cast<uint8_t>(length);
        proof.lengths |= static_cast<uint8_t>(1u << length);
      }
    if (!found) break;
    first = found->end;
  }
  return first - 1;
}

// The last interval is tried first. Where a span shows it, it need not be tried again before that is past; and less and
// less often as long as it stays visible.
template <class Hides>
bool SpanProver::turnsHidden(SpanProof& proof, int32_t& next, uint32_t phase, const Hides& hides) const {
  const int64_t last = std::max(spans_.lastCoveredUpTo(intervals_.last() + law_.worth), intervals_.last()),
                shown = intervals_.last() - intervals_.first();
  proof.keyframe = keyframe_;
  proof.lengths = 0;
  PathSpan* const far = law_.tries_last ? spans_.at(PathSpans::kLengths - 1, last) : nullptr;
  const bool may_be = !far || hides(*far, Towards::kHidden);
  if (may_be)
    proof.until = static_cast<int32_t>(hiddenUntil(proof, phase, intervals_.first(), last, Towards::kHidden, hides));
  if (may_be && proof.until >= last) {
    next = proof.until + 1;
    proof.failures = 0;
    return true;
  }
  const int64_t shortest_end = spans_.shortestEnd(int64_t{proof.until} + 1), length = spans_.shortest(),
                past = may_be ? shortest_end + shown : far->end - (last - intervals_.last()),
                rest = length * ((1 << proof.failures) - 1) + law_.rest;
  next = static_cast<int32_t>(std::max(past, intervals_.last() + 1) + phase % kSpread + rest);
  proof.failures = std::min<uint8_t>(proof.failures + 1, kMaxFailures);
  return false;
}

template <class Hides>
bool SpanProver::staysHidden(SpanProof& proof, int32_t& next, uint32_t phase, const Hides& hides) const {
  const int64_t first = intervals_.first(), last = intervals_.last(),
                known = std::min<int64_t>(proof.until, spans_.firstChangedAfter(proof.keyframe, proof.lengths) - 1);
  if (known >= last && next > last) return true;
  if (known < first) proof.lengths = 0;
  // Where no span has hidden it none will, unless one is made anew.
  const bool is_known_open = proof.until < last && last <= proof.open_until && proof.revision == spans_.revision();
  const int64_t until = is_known_open ? known
                                      : hiddenUntil(proof, phase, std::max(known + 1, first), std::max(last, known + 1),
                                                    Towards::kVisible, hides);
  proof.keyframe = keyframe_;
  proof.until = static_cast<int32_t>(until);
  if (until < last) {
    // A prediction's error is less for the keyframe itself than for all of a span.
    proof.open_until = static_cast<int32_t>(spans_.shortestEnd(std::max(until + 1, first)) - 1);
    proof.revision = spans_.revision();
    next = static_cast<int32_t>(last);
    return intervals_.isPredicted() && hides(spans_.now(), Towards::kVisible);
  }
  const int64_t spare = until - last;
  next = static_cast<int32_t>(until + 1 - (until > known && spare > 0 ? phase % std::min(spare, kSpread) : 0));
  return true;
}

}  // namespace foreland::server
