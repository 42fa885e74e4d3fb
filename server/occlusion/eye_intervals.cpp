#include "server/occlusion/eye_intervals.h"

#include <algorithm>
#include <span>

namespace foreland::server {

namespace {

// Of a sweep's radius: for the rounding of the same eyes; for predictions that change, now, and in prediction errors
// for each interval ahead, squared.
constexpr double kRounding_m = 0.02, kSpare_m = 1, kStray = 0.06;
constexpr double kGuess_m = 0.05;               // an error that no known path has
constexpr double kMostLoose = 3, kLoose_m = 1;  // room that is kept, over what is needed

int64_t divideDown(int64_t a, int64_t b) { return a / b - (a % b < 0 ? 1 : 0); }

}  // namespace

EyeOutlook outlookOf(const ExpectedMotion& motion, Time begin, Time end, Duration interval, double error_m) {
  EyeOutlook outlook{interval, divideDown(begin.us, interval.us), divideDown(end.us - 1, interval.us), {}, error_m};
  const int64_t count = std::min(outlook.last - outlook.first + 1, EyeIntervals::kAhead / 2) + EyeIntervals::kAhead / 2;
  for (int64_t i = outlook.first; i < outlook.first + count; ++i) {
    outlook.eyes.push_back(sweepOf(motion, Time{i * interval.us}, Time{(i + 1) * interval.us}));
    outlook.eyes.back().radius_m += error_m;
  }
  return outlook;
}

void EyeIntervals::expect(const EyeOutlook& outlook, uint32_t keyframe) {
  const int64_t known_end = end_;
  has_changed_ = interval_ != outlook.interval;
  if (has_changed_) ring_.fill({});
  interval_ = outlook.interval;
  first_ = outlook.first;
  last_ = outlook.last;
  is_predicted_ = outlook.error_m > kGuess_m;
  shown_eyes_ = hullOf(std::span(outlook.eyes).first(static_cast<size_t>(last_ - first_ + 1)));
  end_ = first_ + static_cast<int64_t>(outlook.eyes.size());
  for (int64_t i = first_; i < end_; ++i) {
    const EyeSweep& eyes = outlook.eyes[static_cast<size_t>(i - first_)];
    const auto ahead = static_cast<double>(std::max<int64_t>(0, i - last_));
    EyeSweep roomy = eyes;
    roomy.radius_m += is_predicted_ ? kSpare_m + (0.5 + kStray * ahead * ahead) * outlook.error_m : kRounding_m;
    Interval& known = at(i);
    const bool holds = known.number == i && known.eyes.contains(eyes);
    // What was proved for more eyes holds for fewer, but less could be proved.
    if (holds && (known.eyes.radius_m <= kMostLoose * roomy.radius_m + kLoose_m || !known.eyes.contains(roomy)))
      continue;
    if (!holds) known.changed_at = keyframe;
    has_changed_ = has_changed_ || (!holds && i < known_end);
    known.number = i;
    known.eyes = roomy;
  }
  findFirstChanges(keyframe);
}

void EyeIntervals::invalidate(uint32_t keyframe) {
  for (int64_t i = first_; i < end_; ++i) at(i).changed_at = keyframe;
  has_changed_ = true;
  findFirstChanges(keyframe);
}

void EyeIntervals::findFirstChanges(uint32_t keyframe) {
  keyframe_ = keyframe;
  first_changed_.fill(end_);
  for (int64_t i = first_; i < end_; ++i) {
    const uint32_t age = keyframe - at(i).changed_at;
    int64_t& first = first_changed_[std::min<size_t>(age, kSize - 1)];
    first = std::min(first, i);
  }
  // After an older keyframe all has changed that changed after a younger one.
  for (size_t age = 1; age < kSize; ++age) first_changed_[age] = std::min(first_changed_[age], first_changed_[age - 1]);
}

int64_t EyeIntervals::firstChangedAfter(uint32_t keyframe) const {
  const uint32_t age = keyframe_ - keyframe;
  return age == 0 ? end_ : first_changed_[std::min<uint32_t>(age, kSize) - 1];
}

}  // namespace foreland::server
