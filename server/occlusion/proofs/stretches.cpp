#include "server/occlusion/proofs/stretches.h"

#include <algorithm>

namespace foreland::server {

namespace {

constexpr size_t kMaxSpare = 1;
constexpr double kMaxLoose = 4, kLoose_m = 2;  // room that is kept, over what is needed

// Whether a sweep is for far more eyes than another one.
bool isLoose(const EyeSweep& known, const EyeSweep& wanted) {
  return known.radius_m > kMaxLoose * wanted.radius_m + kLoose_m;
}

}  // namespace

void Stretches::revise(uint32_t keyframe) {
  // Without that, no interval is shown again once it is past, nor means another time, nor have stretches other lengths.
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
    for (Stretch& stretch : held) revise(stretch, keyframe);
  collectChanges(keyframe);
  first_ = intervals_.first();
  last_ = intervals_.last();
}

// What was proved for more eyes holds for fewer, but less could be proved: so a loose stretch is made anew, if that
// needs no other eyes. What was proved before then holds for as long as the eyes lie in those of that time, whether or
// not anybody asks for the stretch again.
void Stretches::revise(Stretch& stretch, uint32_t keyframe) {
  if (stretch.end <= intervals_.first()) {
    dropHorizon(stretch);
    stretch = {};
    return;
  }
  const auto parts = intervals_.eyes(stretch.begin, stretch.end);
  const auto holdsFor = [&](const EyeSweep& eyes) {
    return std::all_of(parts.begin(), parts.end(), [&](const EyeSweep& part) { return eyes.contains(part); });
  };
  const bool holds = !stretch.is_made || holdsFor(stretch.eyes);
  if (!holds || !std::all_of(stretch.earlier_eyes.begin(), stretch.earlier_eyes.end(), holdsFor)) {
    stretch.changed_at = keyframe;
    stretch.earlier_eyes.clear();
  }
  stretch.is_made = stretch.is_made && holds;
  if (stretch.is_made && stretch.end <= intervals_.end() && isLoose(stretch.eyes, roomyEyes(stretch)) &&
      stretch.eyes.contains(roomyEyes(stretch))) {
    stretch.is_made = false;
    stretch.earlier_eyes.push_back(stretch.eyes);
  }
  if (!stretch.is_made) dropHorizon(stretch);
}

void Stretches::collectChanges(uint32_t keyframe) {
  changes_.clear();
  bool concerns_shown = false;
  for (size_t length = 0; length < kLengths; ++length)
    for (const Stretch& stretch : held_[length]) {
      if (stretch.changed_at == 0) continue;
      changes_.push_back({stretch.changed_at, stretch.begin, static_cast<Lengths>(1u << length)});
      concerns_shown = concerns_shown || (stretch.begin <= intervals_.last() &&
                                          (stretch.changed_at == keyframe || stretch.begin > last_));
    }
  if (concerns_shown) ++revision_;
}

void Stretches::invalidate(uint32_t keyframe) {
  valid_since_ = keyframe;
  ++revision_;
}

int64_t Stretches::firstChangedAfter(uint32_t keyframe, Lengths lengths) const {
  if (keyframe < valid_since_) return intervals_.first();
  int64_t first = intervals_.end();
  for (const Change& change : changes_)
    if (change.keyframe > keyframe && (change.lengths & lengths) != 0) first = std::min(first, change.begin);
  return first;
}

EyeSweep Stretches::roomyEyes(const Stretch& stretch) const {
  EyeSweep eyes = hullOf(intervals_.eyes(stretch.begin, stretch.end));
  eyes.radius_m += intervals_.room(stretch.end - 1);
  return eyes;
}

int64_t Stretches::lastCoveredUpTo(int64_t interval) const {
  return std::min(interval, (intervals_.end() & -shortest()) - 1);
}

// One that is held may be a part of proofs, so it makes room for no other before it is past.
Stretch* Stretches::at(size_t length, int64_t interval) {
  const uint32_t log2 = intervalsLog2(length);
  const int64_t number = interval >> log2, begin = number << log2, end = (number + 1) << log2;
  if (end > intervals_.end()) return nullptr;
  Stretch& stretch = held_[length][static_cast<size_t>(number) % kHeld];
  const bool is_same = stretch.begin == begin && stretch.end == end;
  if (is_same && stretch.is_made) return &stretch;
  if (!is_same) {
    if (stretch.end > intervals_.first() && stretch.begin < stretch.end) return nullptr;
    dropHorizon(stretch);
    stretch = {};
    stretch.begin = begin;
    stretch.end = end;
  }
  stretch.eyes = roomyEyes(stretch);
  stretch.horizon = sightOf(stretch.eyes);
  stretch.is_made = true;
  return &stretch;
}

Stretch& Stretches::now() {
  if (now_.is_made) return now_;
  now_ = {.begin = intervals_.first(),
          .end = intervals_.last() + 2,
          .is_made = true,
          .changed_at = 0,
          .eyes = hullOf(intervals_.eyes(intervals_.first(), intervals_.last() + 2)),
          .earlier_eyes = {},
          .horizon = nullptr};
  now_.eyes.radius_m += 0.5 * intervals_.room(intervals_.last());
  return now_;
}

// A horizon that is there already, of all of these eyes and perhaps others: an eye at rest needs but one.
std::shared_ptr<Horizon> Stretches::sightOf(const EyeSweep& eyes) const {
  for (const auto& held : held_)
    for (const Stretch& other : held)
      if (other.horizon && other.horizon->eyes().contains(eyes) && !isLoose(other.horizon->eyes(), eyes))
        return other.horizon;
  return nullptr;
}

Horizon& Stretches::horizonOf(Stretch& stretch, double bin) {
  if (stretch.horizon) return *stretch.horizon;
  if (spare_.empty()) {
    stretch.horizon = std::make_shared<Horizon>(*grid_);
  } else {
    stretch.horizon = std::move(spare_.back());
    spare_.pop_back();
  }
  stretch.horizon->look(stretch.eyes, bin);
  return *stretch.horizon;
}

void Stretches::dropHorizon(Stretch& stretch) {
  if (stretch.horizon && stretch.horizon.use_count() == 1 && spare_.size() < kMaxSpare)
    spare_.push_back(std::move(stretch.horizon));
  stretch.horizon.reset();
}

void Stretches::clear() {
  for (auto& held : held_)
    for (Stretch& stretch : held) {
      dropHorizon(stretch);
      stretch = {};
    }
  dropHorizon(now_);
  now_ = {};
}

void Stretches::dropHorizons() {
  for (auto& held : held_)
    for (Stretch& stretch : held) stretch.horizon.reset();
  now_.horizon.reset();
  spare_.clear();
}

// A horizon that several stretches share counts once.
size_t Stretches::bytes() const {
  size_t bytes = 0;
  const auto add = [&](const std::shared_ptr<Horizon>& h) {
    if (h) bytes += h->bytes() / static_cast<size_t>(h.use_count());
  };
  for (const auto& held : held_)
    for (const Stretch& stretch : held) add(stretch.horizon);
  add(now_.horizon);
  for (const auto& horizon : spare_) add(horizon);
  return bytes;
}

}  // namespace foreland::server
