#include "terrain/epochs/epoch_walk.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

#include "base/check.h"
#include "terrain/bounds/heights.h"

namespace foreland::terrain {

namespace {

constexpr int32_t kControlSteps = 64;  // of control heights, to a quantum

}  // namespace

EpochWalk::EpochWalk(const proto::LatticeWindow& window, const proto::Frame& frame, std::span<const int32_t> first,
                     const proto::Epochs& dates)
    : window_(window),
      frame_(frame),
      dates_(dates),
      ground_(first.begin(), first.end()),
      lowest_(ground_),
      highest_(ground_) {
  CHECK_EQ(first.size(), size_t{window.width} * window.height);
}

Status EpochWalk::move(const EpochSamples& epoch) {
  std::optional<float> too_high;
  changed_before_ = std::exchange(change_, {}).window;
  if (dates_.blend() == proto::EpochBlend::kCatmullRom) {
    before_that_.swap(before_);
    before_ = ground_;
  }
  epoch.forEach([&](uint32_t x, uint32_t y, float metres) {
    if (!window_.contains(x, y)) return;
    const auto height = quantised(metres, frame_.height_quantum_m);
    if (!height) too_high = metres;
    const size_t at = static_cast<size_t>(y - window_.y) * window_.width + (x - window_.x);
    if (!height || *height == ground_[at]) return;
    ++change_.samples;
    change_.max_m = std::max(change_.max_m, std::abs(*height - ground_[at]) * frame_.height_quantum_m);
    ground_[at] = *height;
    lowest_[at] = std::min(lowest_[at], *height);
    highest_[at] = std::max(highest_[at], *height);
    change_.window = proto::LatticeWindow::hull(change_.window, {x, y, 1, 1});
  });
  ++epoch_;
  if (!too_high) return {};
  return heightDoesNotFit(epoch.date, *too_high);
}

Status EpochWalk::next(const EpochSamples& epoch, const Visit& visit) {
  if (Status s = move(epoch); !s.ok()) return s;
  if (change_.samples > 0)
    if (Status s = visit({ground_, frame_, 0, change_.window}); !s.ok()) return s;
  return visitControls(visit);
}

// The control heights on either side of the epoch before the last, now that its neighbours are known. The other control
// heights, at the first epoch and at the last, lie between two epochs' heights.
Status EpochWalk::visitControls(const Visit& visit) {
  const proto::LatticeWindow changed = proto::LatticeWindow::hull(changed_before_, change_.window);
  if (dates_.blend() != proto::EpochBlend::kCatmullRom || epoch_ < 2 || changed.isEmpty()) return {};
  const proto::EpochCurve before = dates_.curveAfter(epoch_ - 2), after = dates_.curveAfter(epoch_ - 1);
  for (const auto& [curve, control] : {std::pair(before, size_t{2}), std::pair(after, size_t{1})}) {
    std::array<double, 3> weights{};
    for (uint32_t i = 0; i < 3; ++i) weights[i] = curve.controls[control][epoch_ - 2 + i - curve.first];
    if (Status s = visitControl(changed, weights, visit); !s.ok()) return s;
  }
  return {};
}

// `weights` of the last three epochs. Where none of them differ, so does not their control ground.
Status EpochWalk::visitControl(const proto::LatticeWindow& changed, const std::array<double, 3>& weights,
                               const Visit& visit) {
  control_.resize(ground_.size());
  for (size_t at = 0; at < ground_.size(); ++at) {
    const double middle = before_[at];  // exact where nothing moves
    const double height = middle + weights[0] * (before_that_[at] - middle) + weights[2] * (ground_[at] - middle);
    if (std::fabs(height) >= proto::kMaxHeight)
      return Error{ErrorCode::kLimit,
                   "a height between the epochs does not fit the scene's steps; use a larger "
                   "--vertical-step"};
    control_[at] = static_cast<int32_t>(std::nearbyint(kControlSteps * height));
    lowest_[at] = std::min(lowest_[at], static_cast<int32_t>(std::floor(height)));
    highest_[at] = std::max(highest_[at], static_cast<int32_t>(std::ceil(height)));
  }
  proto::Frame frame = frame_;
  frame.height_quantum_m /= kControlSteps;
  return visit({control_, frame, frame.height_quantum_m, changed});
}

}  // namespace foreland::terrain
