#include "server/occlusion/eye_intervals.h"

#include <algorithm>

namespace foreland::server {

namespace {

constexpr double kEyeRounding_m = 0.02;
// Of predictions that change: now, and in prediction errors for each interval ahead, squared.
constexpr double kSpare_m = 1.5, kStray = 0.12;
constexpr double kGuess_m = 0.05;  // an error that no known path has

int64_t divideDown(int64_t a, int64_t b) { return a / b - (a % b < 0 ? 1 : 0); }

}  // namespace

EyeOutlook outlookOf(const ExpectedMotion& motion, Time begin, Time end, Duration interval, double error_m) {
  EyeOutlook outlook{interval, divideDown(begin.us, interval.us), divideDown(end.us - 1, interval.us), {}, error_m};
  const int64_t count = std::min(outlook.last - outlook.first + 1, EyeIntervals::kAhead / 2) + EyeIntervals::kAhead / 2;
  const std::optional<Time> guessed_until = motion.guessedUntil();
  for (int64_t i = outlook.first; i < outlook.first + count; ++i) {
    if (i > outlook.last && guessed_until && Time{(i + 1) * interval.us} > *guessed_until) break;
    outlook.eyes.push_back(sweepOf(motion, Time{i * interval.us}, Time{(i + 1) * interval.us}));
    outlook.eyes.back().radius_m += error_m;
  }
  return outlook;
}

std::span<const EyeSweep> EyeIntervals::eyes(int64_t begin, int64_t end) const {
  begin = std::max(begin, first());
  end = std::min(end, this->end());
  if (begin >= end) return {};
  return std::span(outlook_.eyes).subspan(static_cast<size_t>(begin - first()), static_cast<size_t>(end - begin));
}

bool EyeIntervals::isPredicted() const { return outlook_.error_m > kGuess_m; }

EyeSweep EyeIntervals::shownEyes() const { return hullOf(eyes(first(), last() + 1)); }

double EyeIntervals::room(int64_t interval) const {
  if (!isPredicted()) return kEyeRounding_m;
  const auto ahead = static_cast<double>(std::max<int64_t>(0, interval - last()));
  return kSpare_m + (0.5 + kStray * ahead * ahead) * outlook_.error_m;
}

}  // namespace foreland::server
