#include "terrain/epochs/epoch_layers.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

namespace foreland::terrain {

namespace {

constexpr int32_t kControlSteps = 64;  // of control heights, to a quantum

}  // namespace

EpochLayers::EpochLayers(const proto::GridTopology& grid, const proto::Frame& frame, Heights first, proto::Epochs dates,
                         unsigned threads)
    : grid_(grid),
      frame_(frame),
      first_(first),
      dates_(std::move(dates)),
      threads_(threads),
      ground_(first.quanta.begin(), first.quanta.end()),
      lowest_(ground_),
      highest_(ground_),
      min_errors_(grid.slotCount()),
      scratch_(grid.slotCount()) {}

void EpochLayers::begin(const EpochSamples& first) {
  section_.add(proto::Epoch{first.time, {}}, {});
  reports_.push_back({first.date, 0, 0, section_.lastBytes()});
}

// Moves the ground to an epoch; moved_ grows by the samples that changed.
Status EpochLayers::move(const EpochSamples& epoch, EpochReport& report) {
  std::optional<float> too_high;
  changed_before_ = std::exchange(changed_, {});
  if (dates_.blend() == proto::EpochBlend::kCatmullRom) {
    before_that_.swap(before_);
    before_ = ground_;
  }
  epoch.forEach([&](uint32_t x, uint32_t y, float metres) {
    const auto height = quantised(metres, frame_.height_quantum_m);
    if (!height) too_high = metres;
    const size_t at = static_cast<size_t>(y) * first_.width + x;
    if (!height || *height == ground_[at]) return;
    ++report.changed_samples;
    report.max_m = std::max(report.max_m, std::abs(*height - ground_[at]) * frame_.height_quantum_m);
    ground_[at] = *height;
    lowest_[at] = std::min(lowest_[at], *height);
    highest_[at] = std::max(highest_[at], *height);
    changed_ = proto::LatticeWindow::hull(changed_, {x, y, 1, 1});
  });
  moved_ = proto::LatticeWindow::hull(moved_, changed_);
  if (!too_high) return {};
  return Error{ErrorCode::kLimit, "epoch " + epoch.date + ": a height of " + std::to_string(*too_high) +
                                      " m does not fit the scene's steps; use a larger --vertical-step"};
}

bool EpochLayers::raiseErrors(const proto::LatticeWindow& rows, const std::function<bool(double)>& keepGoing) {
  std::fill(scratch_.begin(), scratch_.end(), NodeRecord{});
  const auto store = [this](proto::Slot first, std::span<const NodeRecord> records) {
    std::copy(records.begin(), records.end(), scratch_.begin() + static_cast<std::ptrdiff_t>(first));
    for (size_t i = 0; i < records.size(); ++i)
      min_errors_[first + i] = std::max(min_errors_[first + i], records[i].error());
    return true;
  };
  return computeBounds({.grid = grid_,
                        .frame = frame_,
                        .heights = {ground_, first_.width, first_.height},
                        .first_row = rows.y,
                        .last_row = rows.y + rows.height - 1,
                        .nodes = scratch_,
                        .threads = threads_,
                        .store = store,
                        .onProgress = keepGoing});
}

// The control heights on either side of the epoch before the last, now that its neighbours are known. The other control
// heights, at the first epoch and at the last, lie between two epochs' heights.
Status EpochLayers::raiseToControls(const KeepGoing& keepGoing) {
  const proto::LatticeWindow changed = proto::LatticeWindow::hull(changed_before_, changed_);
  const auto last = static_cast<uint32_t>(reports_.size());
  if (dates_.blend() != proto::EpochBlend::kCatmullRom || last < 2 || changed.isEmpty()) return {};
  const proto::EpochCurve before = dates_.curveAfter(last - 2), after = dates_.curveAfter(last - 1);
  for (const auto& [curve, control] : {std::pair(before, size_t{2}), std::pair(after, size_t{1})}) {
    std::array<double, 3> weights{};
    for (uint32_t i = 0; i < 3; ++i) weights[i] = curve.controls[control][last - 2 + i - curve.first];
    if (Status s = raiseToControl(changed, weights, keepGoing); !s.ok()) return s;
  }
  return {};
}

// `weights` of the last three epochs. Where none of them differ, so does not their control ground.
Status EpochLayers::raiseToControl(const proto::LatticeWindow& changed, const std::array<double, 3>& weights,
                                   const KeepGoing& keepGoing) {
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
  std::fill(scratch_.begin(), scratch_.end(), NodeRecord{});
  const auto store = [&](proto::Slot first, std::span<const NodeRecord> records) {
    std::copy(records.begin(), records.end(), scratch_.begin() + static_cast<std::ptrdiff_t>(first));
    for (size_t i = 0; i < records.size(); ++i)
      if (meets(first + static_cast<proto::Slot>(i), changed))
        min_errors_[first + i] = std::max(min_errors_[first + i], records[i].error());
    return true;
  };
  const bool is_complete = computeBounds({.grid = grid_,
                                          .frame = frame,
                                          .heights = {control_, first_.width, first_.height},
                                          .rounding_m = frame.height_quantum_m,
                                          .first_row = changed.y,
                                          .last_row = changed.y + changed.height - 1,
                                          .nodes = scratch_,
                                          .threads = threads_,
                                          .store = store,
                                          .onProgress = keepGoing});
  if (is_complete) return {};
  return Error{ErrorCode::kIo, "stopped before the scene was complete; nothing was written"};
}

// Whether the support of a slot's node reaches the samples of the window, and beyond the data those that repeat them.
bool EpochLayers::meets(proto::Slot slot, const proto::LatticeWindow& w) const {
  const proto::NodeId n = grid_.node(slot);
  if (n == proto::NodeId{}) return false;
  const uint32_t reach = 1u << grid_.scaleLog2(n);
  return n.x() + reach >= w.x && std::min(n.x(), first_.width - 1) <= w.x + w.width - 1 + reach;
}

int32_t EpochLayers::offsetAt(uint32_t x, uint32_t y) const {
  const size_t at = static_cast<size_t>(std::min(y, first_.height - 1)) * first_.width + std::min(x, first_.width - 1);
  return ground_[at] - first_.quanta[at];
}

// Of all vertices in the window, and beyond the data where it reaches the border.
EpochBlocks EpochLayers::offsets(uint32_t epoch) {
  EpochBlocks blocks;
  if (moved_.isEmpty()) return blocks;
  const uint32_t end_x = moved_.x + moved_.width == first_.width ? grid_.maxX() + 1 : moved_.x + moved_.width,
                 end_y = moved_.y + moved_.height == first_.height ? grid_.maxY() + 1 : moved_.y + moved_.height;
  for (uint32_t y = moved_.y; y < end_y; ++y)
    for (uint32_t x = moved_.x; x < end_x; ++x) {
      const int32_t quanta = offsetAt(x, y);
      if (quanta == 0) continue;
      const proto::NodeId v = proto::NodeId::at(x, y);
      if (grid_.isBase(v)) {
        section_.add(proto::BaseOffset{epoch, proto::baseVertexNumber(grid_, v), quanta});
        continue;
      }
      const proto::Slot slot = grid_.slot(v);
      blocks[static_cast<uint32_t>(slot / 64)][slot % 64] = quanta;
    }
  return blocks;
}

Status EpochLayers::add(const EpochSamples& epoch, const std::function<bool(double)>& keepGoing) {
  EpochReport report{.date = epoch.date};
  if (Status s = move(epoch, report); !s.ok()) return s;
  if (report.changed_samples > 0 && !raiseErrors(epoch.window, keepGoing))
    return Error{ErrorCode::kIo, "stopped before the scene was complete; nothing was written"};
  if (Status s = raiseToControls(keepGoing); !s.ok()) return s;
  const auto number = static_cast<uint32_t>(reports_.size());
  section_.add({epoch.time, moved_}, offsets(number));
  report.bytes = section_.lastBytes();
  reports_.push_back(std::move(report));
  return {};
}

HeightRange EpochLayers::range() const {
  return {*std::min_element(lowest_.begin(), lowest_.end()), *std::max_element(highest_.begin(), highest_.end())};
}

}  // namespace foreland::terrain
