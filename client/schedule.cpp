#include "client/schedule.h"

#include <algorithm>

namespace foreland::client {

void Schedule::add(const Interval& interval) {
  intervals_.push_back(interval);
  if (postponed_until_ && interval.begin < *postponed_until_) postpone(intervals_.size() - 1, *postponed_until_);
}

void Schedule::dropBefore(uint32_t version) {
  if (!intervals_.empty() && intervals_.back().version < version) postponed_until_.reset();
  std::erase_if(intervals_, [&](const Interval& i) { return i.version < version && i.version != shown_; });
}

void Schedule::clear() {
  intervals_.clear();
  postponed_until_.reset();
  shown_ = 0;
}

// The interval `first` begins no sooner than at `begin`, and those after it no sooner than the one before them ends.
void Schedule::postpone(size_t first, Time begin) {
  for (size_t i = first; i < intervals_.size(); ++i) {
    Interval& interval = intervals_[i];
    interval.begin = std::max(interval.begin, begin);
    interval.end = std::max(interval.end, interval.begin + kShortestBlend);
    begin = interval.end;
  }
  postponed_until_ = begin;
}

void Schedule::dropUntil(Time now, uint32_t ready, uint32_t coming) {
  size_t due = 0, shown = 0;
  while (due + 1 < intervals_.size() && now >= intervals_[due + 1].begin) ++due;
  for (size_t i = 1; i <= due; ++i)
    if (isReady(i, ready)) shown = i;
  for (size_t i = shown + 1; i < due; ++i)
    if (intervals_[i].version == coming) due = i;
  const bool has_shown = isReady(shown, ready);
  const auto begin = intervals_.begin();
  if (due > shown) {  // those between will not be shown
    intervals_.erase(begin + static_cast<ptrdiff_t>(has_shown ? shown + 1 : shown),
                     begin + static_cast<ptrdiff_t>(due));
    due = has_shown ? shown + 1 : shown;
  }
  intervals_.erase(intervals_.begin(), intervals_.begin() + static_cast<ptrdiff_t>(shown));
  due -= shown;
  if (!isReady(due, ready) && now >= intervals_[due].begin) postpone(due, now);
}

Schedule::Shown Schedule::at(Time now, uint32_t ready, uint32_t coming) {
  if (intervals_.empty()) return {};
  dropUntil(now, ready, coming);
  if (!isReady(0, ready)) return {};
  const Interval& i = intervals_.front();
  shown_ = i.version;
  const double span = static_cast<double>((i.end - i.begin).us);
  const double weight = span <= 0 ? 1.0 : std::clamp(static_cast<double>((now - i.begin).us) / span, 0.0, 1.0);
  const Duration covered = i.shownTo() - i.shownFrom();
  const Time scene = i.shownFrom() + Duration{static_cast<int64_t>(weight * static_cast<double>(covered.us))};
  return {&i, weight, scene, intervals_.size() == 1 && now >= i.end};
}

uint32_t Schedule::next() const {
  for (const Interval& i : intervals_)
    if (i.version > shown_) return i.version;
  return 0;
}

}  // namespace foreland::client
