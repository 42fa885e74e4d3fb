#include "client/fly/track.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <system_error>

#include "client/fly/track_builder.h"

namespace foreland::client {

namespace {

constexpr double kRadPerDeg = 0.017453292519943295;
constexpr size_t kNotedSkips = 5;
constexpr double kAssumedSpeed_mps = 10;  // for tracks without times
constexpr double kGap_s = 60;             // longer silences are noted
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
  notes_.push_back(name_ + ":" + std::to_string(line) + ": " + std::string(why) + "; skipped");
}

void TrackBuilder::add(size_t line, const RawFix& fix) {
  if (isFull()) return;
  if (!(std::fabs(fix.latitude_deg) <= 90) || !(std::fabs(fix.longitude_deg) <= 180))
    return skip(line, "latitude or longitude off the globe");
  if (fix.height_m && !(*fix.height_m >= kLowest_m && *fix.height_m <= kHighest_m)) return skip(line, "absurd height");
  if (fix.time_s && !std::isfinite(*fix.time_s)) return skip(line, "time is not a number");
  fixes_.push_back(fix);
  if (isFull()) note("more than " + std::to_string(Track::kMaxFixes) + " fixes; the rest is not read");
}

void TrackBuilder::fillTimes() {
  const auto timed = std::ranges::count_if(fixes_, [](const RawFix& f) { return f.time_s.has_value(); });
  if (static_cast<size_t>(timed) == fixes_.size()) return;
  if (timed > 0) {
    note(std::to_string(fixes_.size() - static_cast<size_t>(timed)) + " fixes have no time; skipped");
    std::erase_if(fixes_, [](const RawFix& f) { return !f.time_s; });
    return;
  }
  note("no times recorded; 10 m/s along the track assumed");
  double time_s = 0;
  for (size_t i = 0; i < fixes_.size(); ++i) {
    if (i > 0) time_s += roughDistance(fixes_[i - 1], fixes_[i]) / kAssumedSpeed_mps;
    fixes_[i].time_s = time_s;
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
  fillTimes();
  Track track{.heights = fillHeights()};
  size_t repeated = 0, gaps = 0;
  double longest_gap_s = 0;
  for (const RawFix& f : fixes_) {
    const double time_s = *f.time_s - *fixes_.front().time_s;
    if (!track.fixes.empty() && time_s <= track.fixes.back().time_s) {
      ++repeated;
      continue;
    }
    const double gap_s = track.fixes.empty() ? 0 : time_s - track.fixes.back().time_s;
    if (gap_s > kGap_s) ++gaps;
    longest_gap_s = std::max(longest_gap_s, gap_s);
    track.fixes.push_back({time_s, f.latitude_deg * kRadPerDeg, f.longitude_deg * kRadPerDeg, f.height_m.value_or(0)});
  }
  if (track.fixes.size() < 2) return tooFew(std::string(kind) + " track");
  if (skipped_ > kNotedSkips) note(std::to_string(skipped_ - kNotedSkips) + " more lines or points skipped");
  if (repeated > 0) note(std::to_string(repeated) + " fixes repeat an earlier time or go back in time; skipped");
  if (gaps > 0)
    note(std::to_string(gaps) + " gaps of more than a minute (longest " + std::to_string(std::lround(longest_gap_s)) +
         " s); flown straight");
  track.skipped = skipped_ + repeated;
  track.notes = std::move(notes_);
  return track;
}

Result<Track> readTrack(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error))
    return Error{ErrorCode::kInvalidArgument,
                 path.string() + ": is a directory; name an IGC or GPX file, or one of camera frames"};
  const uintmax_t size = std::filesystem::file_size(path, error);
  if (error) return Error{ErrorCode::kNotFound, path.string() + ": " + error.message()};
  if (size > Track::kMaxFileBytes)
    return Error{ErrorCode::kLimit, path.string() + ": larger than 256 MiB; cut the track into parts"};
  std::string text(size, '\0');
  std::ifstream in(path, std::ios::binary);
  in.read(text.data(), static_cast<std::streamsize>(size));
  if (!in) return Error{ErrorCode::kIo, path.string() + ": cannot be read"};
  const size_t start = text.find_first_not_of(" \t\r\n\xef\xbb\xbf");
  if (start != std::string::npos && text[start] == '<') return parseGpx(text, path.string());
  if (start != std::string::npos && text.compare(start, 2, "F ") == 0) return parseCameraFrames(text, path.string());
  return parseIgc(text, path.string());
}

}  // namespace foreland::client
