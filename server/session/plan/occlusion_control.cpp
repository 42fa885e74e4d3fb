#include "server/session/plan/occlusion_control.h"

#include <algorithm>
#include <cmath>

namespace foreland::server {

namespace {

constexpr double kSmoothing = 0.1;                   // of a keyframe's times: over some two seconds
constexpr double kPerComparison = 10;                // what proofs take for each second of comparing
constexpr Duration kSettled = Duration::seconds(3);  // after that the first proofs have turned up
// Fewer left-out nodes than this, for each that is held, are worth no proofs that take a notable part of a keyframe.
constexpr double kWorth = 0.1, kNotable = 0.1;
constexpr Duration kFirstRest = Duration::seconds(10), kLongestRest = Duration::seconds(80);

}  // namespace

// Multiples of the golden ratio.
double OcclusionControl::rankOf(uint64_t number) {
  return std::fmod(0.6180339887498949 * static_cast<double>(number), 1.0);
}

// Whether the keyframe would not be faster without. Part of a keyframe's time does not depend on the section's size,
// and the frontier of a section grows more slowly than the section.
bool OcclusionControl::isCheap() const {
  constexpr double kInProportion = 0.25;
  const double rest_s = std::max(0.0, all_s_ - occlusion_s_);
  return occlusion_s_ <= kInProportion * left_out_ * rest_s;
}

bool OcclusionControl::isWanted(Time now, double share, double rank) const {
  if (now < rests_until_) return false;
  return rank < share || (effort_ == Effort::kAll && left_out_ > 0 && isCheap());
}

OcclusionControl::Effort OcclusionControl::next(Time now, double share, double rank, bool is_from_nothing) {
  // A section from nothing is smaller, and made faster, without what is hidden.
  const bool is_wanted = isWanted(now, share, rank) || (is_from_nothing && share > 0 && now >= rests_until_);
  if (is_wanted && effort_ != Effort::kAll) {
    effort_ = Effort::kAll;
    began_ = now;
    spent_s_ = 0;
  } else if (!is_wanted && effort_ == Effort::kAll) {
    effort_ = Effort::kFading;
    times_shed_ += now < rests_until_ ? 0 : 1;
  } else if (effort_ == Effort::kFading && (!hides_anything_ || is_from_nothing)) {
    effort_ = Effort::kNone;
    left_out_ = occlusion_s_ = 0;
  }
  return effort_;
}

void OcclusionControl::observe(Duration all, Duration occlusion, bool hides_anything) {
  all_s_ += kSmoothing * (all.toSeconds() - all_s_);
  occlusion_s_ += kSmoothing * (occlusion.toSeconds() - occlusion_s_);
  spent_s_ += occlusion.toSeconds();
  hides_anything_ = hides_anything;
}

bool OcclusionControl::isComparisonDue(Time now, Duration cost) const {
  return effort_ == Effort::kAll && now - began_ >= kSettled && spent_s_ >= kPerComparison * cost.toSeconds();
}

void OcclusionControl::compared(Time now, size_t held, size_t with_hidden) {
  spent_s_ = 0;
  const auto nodes = static_cast<double>(std::max<size_t>(held, 1));
  left_out_ = std::max(0.0, static_cast<double>(with_hidden) - nodes) / nodes;
  if (left_out_ >= kWorth || occlusion_s_ < kNotable * all_s_) {
    rest_ = {};
    return;
  }
  rest_ = std::clamp(rest_ * 2, kFirstRest, kLongestRest);
  rests_until_ = now + rest_;
  ++times_worthless_;
}

}  // namespace foreland::server
