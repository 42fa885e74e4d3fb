#include "server/occlusion/stretches.h"

#include <algorithm>
#include <span>

namespace foreland::server {

namespace {

constexpr size_t kMostSpare = 1;

// Whether what is found for some eyes is found for all parts of a stretch, and not for a far larger room.
bool holds(const EyeSweep& known, std::span<const EyeSweep> parts, double radius_m) {
  constexpr double kMostLoose = 3, kLoose_m = 1;
  return known.radius_m <= kMostLoose * radius_m + kLoose_m &&
         std::all_of(parts.begin(), parts.end(), [&](const EyeSweep& part) { return known.contains(part); });
}

}  // namespace

Stretch* Stretches::at(size_t length, int64_t interval, uint32_t keyframe) {
  const uint32_t log2 = kLengthLog2[length];
  const int64_t number = interval >> log2, begin = std::max(number << log2, intervals_.first()),
                end = (number + 1) << log2;
  if (end > intervals_.end()) return nullptr;
  Stretch& stretch = held_[length][static_cast<size_t>(number) % kHeld];
  if (stretch.end == end && stretch.keyframe == keyframe) return &stretch;
  const auto parts = std::span(parts_).first(collect(begin, end));
  const EyeSweep eyes = hullOf(parts);
  if (stretch.end == end && holds(stretch.eyes, parts, eyes.radius_m)) {
    stretch.keyframe = keyframe;
    return &stretch;
  }
  std::shared_ptr<Horizon> horizon = sightOf(parts, eyes.radius_m, length);
  drop(stretch);
  stretch = {begin, end, keyframe, eyes, std::move(horizon)};
  return &stretch;
}

Stretch& Stretches::now(uint32_t keyframe) {
  if (now_.keyframe == keyframe) return now_;
  drop(now_);
  now_ = {intervals_.first(), intervals_.last() + 1, keyframe, intervals_.shownEyes(), nullptr};
  return now_;
}

size_t Stretches::collect(int64_t begin, int64_t end) {
  for (int64_t i = begin; i < end; ++i) parts_[static_cast<size_t>(i - begin)] = intervals_.eyes(i);
  return static_cast<size_t>(end - begin);
}

// A horizon that is there already, of all of these eyes and perhaps others: an eye at rest needs but one.
std::shared_ptr<Horizon> Stretches::sightOf(std::span<const EyeSweep> parts, double radius_m, size_t length) const {
  for (const Stretch& other : held_[length])
    if (other.horizon && holds(other.horizon->eyes(), parts, radius_m)) return other.horizon;
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

void Stretches::drop(Stretch& stretch) {
  if (stretch.horizon && stretch.horizon.use_count() == 1 && spare_.size() < kMostSpare)
    spare_.push_back(std::move(stretch.horizon));
  stretch = {};
}

void Stretches::dropPast() {
  for (auto& held : held_)
    for (Stretch& stretch : held)
      if (stretch.end <= intervals_.first()) drop(stretch);
}

void Stretches::clear() {
  for (auto& held : held_)
    for (Stretch& stretch : held) drop(stretch);
  drop(now_);
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
