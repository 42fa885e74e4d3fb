#include "server/occlusion/proofs/eye_intervals.h"

#include <algorithm>

namespace foreland::server {

namespace {

constexpr double kEyeRounding_m = 0.02;
constexpr double kGuess_m = 0.05;  // an error that no known path has

int64_t divideDown(int64_t a, int64_t b) { return a / b - (a % b < 0 ? 1 : 0); }

}  // namespace

// A keyframe may be shown for any number of intervals. The first ones have capsules of their own; all that follow share
// one, and beyond kMaxShown they count as the last one, so that neither cost nor memory grows with a stall. The numbers
// ahead of that then name times at which it is still shown, and share the capsule, too.
PredictedEyePath eyePathOf(const ExpectedMotion& motion, Time begin, Time end, Duration interval, double error_m) {
  const int64_t first = divideDown(begin.us, interval.us),
                shown_end = std::max(first, divideDown(end.us - 1, interval.us)) + 1,
                apart_end = std::min(shown_end, first + EyeIntervals::kAhead),
                last = std::min(shown_end, first + EyeIntervals::kMaxShown) - 1;
  PredictedEyePath eye_path{interval, first, last, {}, error_m};
  constexpr int64_t kAfter = EyeIntervals::kAhead / 2;
  const auto add = [&](int64_t from, int64_t to, int64_t times) {
    EyeCapsule eyes = capsuleOf(motion, Time{from * interval.us}, Time{to * interval.us});
    eyes.radius_m += error_m;
    eye_path.eyes.insert(eye_path.eyes.end(), static_cast<size_t>(times), eyes);
  };
  for (int64_t i = first; i < apart_end; ++i) add(i, i + 1, 1);
  const bool is_cut = last + 1 < shown_end;
  if (apart_end < shown_end) add(apart_end, shown_end, last + 1 - apart_end + (is_cut ? kAfter : 0));
  if (is_cut) return eye_path;
  const std::optional<Time> guessed_until = motion.guessedUntil();
  for (int64_t i = shown_end; i < shown_end + kAfter; ++i) {
    if (guessed_until && Time{(i + 1) * interval.us} > *guessed_until) break;
    add(i, i + 1, 1);
  }
  return eye_path;
}

std::span<const EyeCapsule> EyeIntervals::eyes(int64_t begin, int64_t end) const {
  begin = std::max(begin, first());
  end = std::min(end, this->end());
  if (begin >= end) return {};
  return std::span(eye_path_.eyes).subspan(static_cast<size_t>(begin - first()), static_cast<size_t>(end - begin));
}

bool EyeIntervals::isPredicted() const { return eye_path_.error_m > kGuess_m; }

EyeCapsule EyeIntervals::shownEyes() const { return hullOf(eyes(first(), last() + 1)); }

double EyeIntervals::room(int64_t interval, const PredictionRoom& room) const {
  if (!isPredicted()) return kEyeRounding_m;
  const auto ahead = static_cast<double>(std::max<int64_t>(0, interval - last()));
  return room.spare_m + (room.errors + room.errors_ahead * ahead * ahead) * eye_path_.error_m;
}

}  // namespace foreland::server
