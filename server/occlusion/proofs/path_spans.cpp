#include "server/occlusion/proofs/path_spans.h"

#include <algorithm>

namespace foreland::server {

namespace {

constexpr size_t kMaxSpare = 1;
constexpr double kMaxLoose = 4, kLoose_m = 2;  // room that is kept, over what is needed

// Whether a capsule is for far more eyes than another one.
bool isLoose(const EyeCapsule& known, const EyeCapsule& wanted) {
  return known.radius_m > kMaxLoose * wanted.radius_m + kLoose_m;
}

}  // namespace

void PathSpans::revise(uint32_t keyframe) {
  // Without that, no interval is shown again once it is past, nor means another time, nor have spans other lengths.
  if (intervals_.interval() != interval_ || intervals_.isPredicted() != is_predicted_ || intervals_.first() < first_) {
    clear();
    invalidate(keyframe);
    interval_ = intervals_.interval();
    is_predicted_ = intervals_.isPredicted();
  }
  if (now_.is_made && !now_.eyes.contains(intervals_.shownEyes())) {
    now_.is_made = false;
    dropHorizon(now_);
  }
  for (auto& held : held_)
    for (PathSpan& span : held) revise(span, keyframe);
  collectChanges(keyframe);
  first_ = intervals_.first();
  last_ = intervals_.last();
}

// What was proved for more eyes holds for fewer, but less could be proved: so a loose span is made anew, if that
// needs no other eyes. What was proved before then holds for as long as the eyes lie in those of that time, whether or
// not anybody asks for the span again.
void PathSpans::revise(PathSpan& span, uint32_t keyframe) {
  if (span.end <= intervals_.first()) {
    dropHorizon(span);
    span = {};
    return;
  }
  const auto parts = intervals_.eyes(span.begin, span.end);
  const auto holdsFor = [&](const EyeCapsule& eyes) {
    return std::all_of(parts.begin(), parts.end(), [&](const EyeCapsule& part) { return eyes.contains(part); });
  };
  const bool holds = !span.is_made || holdsFor(span.eyes);
  if (!holds || !std::all_of(span.earlier_eyes.begin(), span.earlier_eyes.end(), holdsFor)) {
    span.changed_at = keyframe;
    span.earlier_eyes.clear();
  }
  span.is_made = span.is_made && holds;
  if (span.is_made && span.end <= intervals_.end() && isLoose(span.eyes, roomyEyes(span)) &&
      span.eyes.contains(roomyEyes(span))) {
    span.is_made = false;
    span.earlier_eyes.push_back(span.eyes);
  }
  if (!span.is_made) dropHorizon(span);
}

void PathSpans::collectChanges(uint32_t keyframe) {
  changes_.clear();
  bool concerns_shown = false;
  for (size_t length = 0; length < kLengths; ++length)
    for (const PathSpan& span : held_[length]) {
      if (span.changed_at == 0) continue;
      changes_.push_back({span.changed_at, span.begin, static_cast<Lengths>(1u << length)});
      concerns_shown =
          concerns_shown || (span.begin <= intervals_.last() && (span.changed_at == keyframe || span.begin > last_));
    }
  if (concerns_shown) ++revision_;
}

void PathSpans::invalidate(uint32_t keyframe) {
  valid_since_ = keyframe;
  ++revision_;
}

int64_t PathSpans::firstChangedAfter(uint32_t keyframe, Lengths lengths) const {
  if (keyframe < valid_since_) return intervals_.first();
  int64_t first = intervals_.end();
  for (const Change& change : changes_)
    if (change.keyframe > keyframe && (change.lengths & lengths) != 0) first = std::min(first, change.begin);
  return first;
}

EyeCapsule PathSpans::roomyEyes(const PathSpan& span) const {
  EyeCapsule eyes = hullOf(intervals_.eyes(span.begin, span.end));
  eyes.radius_m += intervals_.room(span.end - 1, shape_.room);
  return eyes;
}

int64_t PathSpans::lastCoveredUpTo(int64_t interval) const {
  return std::min(interval, (intervals_.end() & -shortest()) - 1);
}

// One that is held may be a part of proofs, so it makes room for no other before it is past.
PathSpan* PathSpans::at(size_t length, int64_t interval) {
  const uint32_t log2 = intervalsLog2(length);
  const int64_t number = interval >> log2, begin = number << log2, end = (number + 1) << log2;
  if (end > intervals_.end()) return nullptr;
  PathSpan& span = held_[length][static_cast<size_t>(number) % kHeld];
  const bool is_same = span.begin == begin && span.end == end;
  if (is_same && span.is_made) return &span;
  if (!is_same) {
    if (span.end > intervals_.first() && span.begin < span.end) return nullptr;
    dropHorizon(span);
    span = {};
    span.begin = begin;
    span.end = end;
  }
  span.eyes = roomyEyes(span);
  span.horizon = sightOf(span.eyes);
  span.is_made = true;
  return &span;
}

PathSpan& PathSpans::now() {
  if (now_.is_made) return now_;
  now_ = {.begin = intervals_.first(),
          .end = intervals_.last() + 2,
          .is_made = true,
          .changed_at = 0,
          .eyes = hullOf(intervals_.eyes(intervals_.first(), intervals_.last() + 2)),
          .earlier_eyes = {},
          .horizon = nullptr};
  now_.eyes.radius_m += 0.5 * intervals_.room(intervals_.last(), shape_.room);
  return now_;
}

// A horizon that is there already, of all of these eyes and perhaps others: an eye at rest needs but one.
std::shared_ptr<Horizon> PathSpans::sightOf(const EyeCapsule& eyes) const {
  for (const auto& held : held_)
    for (const PathSpan& other : held)
      if (other.horizon && other.horizon->eyes().contains(eyes) && !isLoose(other.horizon->eyes(), eyes))
        return other.horizon;
  return nullptr;
}

Horizon& PathSpans::horizonOf(PathSpan& span, double bin) {
  if (span.horizon) return *span.horizon;
  if (spare_.empty()) {
    span.horizon = std::make_shared<Horizon>(*grid_);
  } else {
    span.horizon = std::move(spare_.back());
    spare_.pop_back();
  }
  span.horizon->look(span.eyes, bin);
  return *span.horizon;
}

void PathSpans::dropHorizon(PathSpan& span) {
  if (span.horizon && span.horizon.use_count() == 1 && spare_.size() < kMaxSpare)
    spare_.push_back(std::move(span.horizon));
  span.horizon.reset();
}

void PathSpans::clear() {
  for (auto& held : held_)
    for (PathSpan& span : held) {
      dropHorizon(span);
      span = {};
    }
  dropHorizon(now_);
  now_ = {};
}

void PathSpans::lookOver(const HorizonGrid* grid) {
  dropHorizons();
  grid_ = grid;
}

void PathSpans::dropHorizons() {
  for (auto& held : held_)
    for (PathSpan& span : held) span.horizon.reset();
  now_.horizon.reset();
  spare_.clear();
}

// A horizon that several spans share counts once.
size_t PathSpans::bytes() const {
  size_t bytes = 0;
  const auto add = [&](const std::shared_ptr<Horizon>& h) {
    if (h) bytes += h->bytes() / static_cast<size_t>(h.use_count());
  };
  for (const auto& held : held_)
    for (const PathSpan& span : held) add(span.horizon);
  add(now_.horizon);
  for (const auto& horizon : spare_) add(horizon);
  return bytes;
}

}  // namespace foreland::server
