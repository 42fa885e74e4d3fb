#include "client/fly/tracks/track.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "client/fly/tracks/track_builder.h"

namespace foreland::client {

namespace {

constexpr double kRadPerDeg = 0.017453292519943295;
constexpr size_t kNotedSkips = 5;
constexpr double kAssumedSpeed_mps = 10;  // for tracks without times
constexpr double kFastest_mps = 340;      // that times on both sides of a gap are believed
constexpr size_t kStragglers = 5;         // so many fixes in a row may be out of order
constexpr double kNearZero_deg = 1;
constexpr double kGap_s = 60;  // longer silences are noted
constexpr double kLowest_m = -12'000, kHighest_m = 100'000;

// Along a sphere; good to half a percent, which is enough to spread times.
double roughDistance(const RawFix& a, const RawFix& b) {
  const double dy = (b.latitude_deg - a.latitude_deg) * kRadPerDeg;
  const double dx = (b.longitude_deg - a.longitude_deg) * kRadPerDeg * std::cos(a.latitude_deg * kRadPerDeg);
  return 6'371'000.0 * std::hypot(dx, dy);
}

}  // namespace

void TrackBuilder::skip(size_t line, std::string_view why) {
  if (++skipped_ > kNotedSkips) return;
  notes_.push_back(name_ + (place_.empty() ? ":" : ": " + place_ + " ") + std::to_string(line) + ": " +
                   std::string(why) + "; skipped");
}

void TrackBuilder::add(size_t line, const RawFix& fix) {
  if (isFull()) return;
  if (!(std::fabs(fix.latitude_deg) <= 90) || !(std::fabs(fix.longitude_deg) <= 180))
    return skip(line, "latitude or longitude off the globe");
  if (fix.height_m && !(*fix.height_m >= kLowest_m && *fix.height_m <= kHighest_m)) return skip(line, "absurd height");
  if (fix.time_s && !std::isfinite(*fix.time_s)) return skip(line, "time is not a number");
  fixes_.push_back(fix);
  fixes_.back().line = line;
  if (isFull()) note("more than " + std::to_string(Track::kMaxFixes) + " fixes; the rest is not read");
}

// Receivers write 0, 0 while they have no position.
void TrackBuilder::dropZeros() {
  const auto isZero = [](const RawFix& f) { return f.latitude_deg == 0 && f.longitude_deg == 0; };
  const bool passes_there = std::ranges::any_of(fixes_, [&](const RawFix& f) {
    return !isZero(f) && std::hypot(f.latitude_deg, f.longitude_deg) < kNearZero_deg;
  });
  if (passes_there) return;
  for (const RawFix& f : fixes_)
    if (isZero(f)) skip(f.line, "no position: latitude and longitude are 0");
  std::erase_if(fixes_, isZero);
}

// Drops fixes that are out of order for a moment; where the clock does not come back it is set anew.
void TrackBuilder::repairTimes() {
  std::vector<RawFix> kept;
  double shift_s = 0;  // of the clock
  size_t reset = 0;
  bool was_reset = false;  // at the fix before
  for (size_t i = 0; i < fixes_.size(); ++i) {
    RawFix fix = fixes_[i];
    fix.time_s = *fix.time_s + shift_s;
    if (kept.empty() || *fix.time_s > *kept.back().time_s) {
      kept.push_back(fix);
      was_reset = false;
      continue;
    }
    const double last_s = *kept.back().time_s;
    // A single fix at the end may be out of order, too.
    bool comes_back = i + 1 == fixes_.size() && kept.size() > 1 && !was_reset;
    for (size_t j = i + 1; j < fixes_.size() && j <= i + kStragglers; ++j)
      comes_back = comes_back || *fixes_[j].time_s + shift_s > last_s;
    was_reset = false;
    const double step_s = roughDistance(kept.back(), fix) / kAssumedSpeed_mps;
    if (comes_back || !(last_s + step_s > last_s)) {
      ++repeated_;
      continue;
    }
    shift_s += last_s + step_s - *fix.time_s;
    fix.time_s = last_s + step_s;
    kept.push_back(fix);
    was_reset = true;
    ++reset;
  }
  fixes_ = std::move(kept);
  if (repeated_ > 0) note(std::to_string(repeated_) + " fixes repeat an earlier time or go back in time; skipped");
  if (reset > 0)
    note("the clock stands still or goes back at " + std::to_string(reset) +
         " fixes; flown at 10 m/s there (--speed changes it)");
}

// Fixes without a time from `first` on, `last` not included, get times along the track: at one speed from the fix
// before to the one after, if their times allow it, else at an assumed speed.
void TrackBuilder::spreadTimes(size_t first, size_t last) {
  const size_t begin = first > 0 ? first - 1 : 0, end = std::min(last, fixes_.size() - 1);
  std::vector<double> along_m(end - begin + 1, 0);  // from `begin`
  for (size_t i = begin + 1; i <= end; ++i)
    along_m[i - begin] = along_m[i - begin - 1] + roughDistance(fixes_[i - 1], fixes_[i]);
  const std::optional<double> before_s = fixes_[begin].time_s, after_s = fixes_[end].time_s;
  const double total_m = along_m.back(), given_s = before_s && after_s ? *after_s - *before_s : 0;
  const bool is_given = given_s > 0 && total_m > 0 && total_m / given_s <= kFastest_mps;
  const double speed_mps = is_given ? total_m / given_s : kAssumedSpeed_mps;
  const double begin_s = before_s ? *before_s : after_s ? *after_s - total_m / speed_mps : 0;
  for (size_t i = first; i < last; ++i) fixes_[i].time_s = begin_s + along_m[i - begin] / speed_mps;
}

void TrackBuilder::fillTimes() {
  const auto hasNone = [](const RawFix& f) { return !f.time_s.has_value(); };
  const auto untimed = static_cast<size_t>(std::ranges::count_if(fixes_, hasNone));
  if (untimed == 0) return;
  if (untimed == fixes_.size())
    note("no times recorded; 10 m/s along the track assumed (--speed changes it)");
  else
    note(std::to_string(untimed) + " fixes have no time; flown at a constant speed there (--speed changes it)");
  for (size_t first = 0; first < fixes_.size(); ++first) {
    if (!hasNone(fixes_[first])) continue;
    size_t last = first;
    while (last < fixes_.size() && hasNone(fixes_[last])) ++last;
    spreadTimes(first, last);
    first = last;
  }
}

// A missing height takes that of the fix before it, the first ones that of the first known.
TrackHeights TrackBuilder::fillHeights() {
  const auto known = std::ranges::find_if(fixes_, [](const RawFix& f) { return f.height_m.has_value(); });
  if (known == fixes_.end()) {
    note("no heights recorded");
    return TrackHeights::kMissing;
  }
  double last_m = *known->height_m;
  for (RawFix& f : fixes_) {
    last_m = f.height_m.value_or(last_m);
    f.height_m = last_m;
  }
  return TrackHeights::kRecorded;
}

Error TrackBuilder::tooFew(std::string_view expected) const {
  std::string message =
      name_ + ": fewer than two usable fixes, so there is nothing to fly; expected " + std::string(expected);
  if (skipped_ > 0)
    message += " (" + std::to_string(skipped_) + " lines or points were unusable; first: " + notes_.front() + ")";
  return {ErrorCode::kMalformed, message};
}

Result<Track> TrackBuilder::finish(Track cameras) && {
  if (cameras.cameras.size() < 2) return tooFew("camera frames");
  if (skipped_ > kNotedSkips) note(std::to_string(skipped_ - kNotedSkips) + " more lines skipped");
  cameras.skipped = skipped_;
  cameras.notes = std::move(notes_);
  return cameras;
}

Result<Track> TrackBuilder::finish(std::string_view kind) && {
  dropZeros();
  fillTimes();
  repairTimes();
  Track track{.heights = fillHeights()};
  size_t gaps = 0;
  double longest_gap_s = 0;
  for (const RawFix& f : fixes_) {
    const double time_s = *f.time_s - *fixes_.front().time_s;
    const double gap_s = track.fixes.empty() ? 0 : time_s - track.fixes.back().time_s;
    if (gap_s > kGap_s) ++gaps;
    longest_gap_s = std::max(longest_gap_s, gap_s);
    track.fixes.push_back({time_s, f.latitude_deg * kRadPerDeg, f.longitude_deg * kRadPerDeg, f.height_m.value_or(0)});
  }
  if (track.fixes.size() < 2) return tooFew(std::string(kind) + " track");
  if (skipped_ > kNotedSkips) note(std::to_string(skipped_ - kNotedSkips) + " more lines or points skipped");
  if (gaps > 0)
    note(std::to_string(gaps) + " gaps of more than a minute (longest " + std::to_string(std::lround(longest_gap_s)) +
         " s); flown straight");
  track.skipped = skipped_ + repeated_;
  track.notes = std::move(notes_);
  return track;
}

}  // namespace foreland::client
