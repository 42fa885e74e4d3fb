#include "proto/section/epochs.h"

#include <cmath>
#include <string>
#include <tuple>

namespace foreland::proto {

LatticeWindow LatticeWindow::hull(const LatticeWindow& a, const LatticeWindow& b) {
  if (a.isEmpty()) return b;
  if (b.isEmpty()) return a;
  const uint32_t x = std::min(a.x, b.x), y = std::min(a.y, b.y);
  return {x, y, std::max(a.x + a.width, b.x + b.width) - x, std::max(a.y + a.height, b.y + b.height) - y};
}

namespace {

bool isBefore(const BaseOffset& a, const BaseOffset& b) {
  return std::tie(a.epoch, a.vertex) < std::tie(b.epoch, b.vertex);
}

}  // namespace

void sortBaseOffsets(std::vector<BaseOffset>& offsets) { std::sort(offsets.begin(), offsets.end(), isBefore); }

int32_t baseOffsetAt(std::span<const BaseOffset> sorted, uint32_t epoch, uint32_t vertex) {
  const auto at = std::lower_bound(sorted.begin(), sorted.end(), BaseOffset{epoch, vertex, 0}, isBefore);
  return at != sorted.end() && at->epoch == epoch && at->vertex == vertex ? at->quanta : 0;
}

uint32_t baseVertexNumber(const GridTopology& grid, NodeId base) {
  const uint32_t k = grid.shape().root_log2, x = base.x() >> k, y = base.y() >> k, row = grid.shape().roots_x + 1;
  if (grid.scaleLog2(base) >= k) return y * row + x;
  return row * (grid.shape().roots_y + 1) + y * grid.shape().roots_x + x;
}

Result<Epochs> Epochs::create(const GridShape& shape, std::vector<Epoch> epochs) {
  const auto malformed = [](size_t i, const char* what) {
    return Error{ErrorCode::kMalformed, "epoch " + std::to_string(i + 1) + " " + what};
  };
  if (epochs.size() > kMost) return Error{ErrorCode::kLimit, "a scene has at most 1024 epochs"};
  for (size_t i = 0; i < epochs.size(); ++i) {
    const Epoch& epoch = epochs[i];
    const LatticeWindow& w = epoch.moved;
    if (epoch.time.us < -kMostTime_us || epoch.time.us > kMostTime_us) return malformed(i, "has an absurd date");
    if (i > 0 && epoch.time <= epochs[i - 1].time) return malformed(i, "is not later than the one before it");
    if (uint64_t{w.x} + w.width > shape.samples_x || uint64_t{w.y} + w.height > shape.samples_y)
      return malformed(i, "reaches beyond the data");
    if (i == 0 && !w.isEmpty()) return malformed(i, "differs from itself");
  }
  Epochs out;
  out.epochs_ = std::move(epochs);
  out.last_x_ = shape.samples_x - 1;
  out.last_y_ = shape.samples_y - 1;
  return out;
}

Time Epochs::clamp(double us) const {
  if (!(us > static_cast<double>(first().us))) return first();
  if (us >= static_cast<double>(last().us)) return last();
  return {static_cast<int64_t>(us)};
}

EpochWeights Epochs::weightsAt(Time scene_time) const {
  const auto after = std::upper_bound(epochs_.begin(), epochs_.end(), scene_time,
                                      [](Time t, const Epoch& epoch) { return t < epoch.time; });
  if (after == epochs_.begin()) return {};
  const auto at = static_cast<uint32_t>(after - epochs_.begin()) - 1;
  if (after == epochs_.end() || epochs_[at].time == scene_time) return {{at, at}, {1, 0}, 1};
  const double share = static_cast<double>((scene_time - epochs_[at].time).us) /
                       static_cast<double>((after->time - epochs_[at].time).us);
  return {{at, at + 1}, {1 - share, share}, 2};
}

Time Epochs::towards(Time from, Time wanted) const {
  if (wanted > from) {
    for (const Epoch& epoch : epochs_)
      if (epoch.time > from && epoch.time < wanted) return epoch.time;
  } else {
    for (size_t i = epochs_.size(); i-- > 0;)
      if (epochs_[i].time < from && epochs_[i].time > wanted) return epochs_[i].time;
  }
  return wanted;
}

Time SceneClock::timeAt(const Epochs& epochs, Time t) const {
  return epochs.clamp(std::nearbyint(static_cast<double>(scene_time.us) +
                                     rate * static_cast<double>(std::max<int64_t>((t - at).us, 0))));
}

}  // namespace foreland::proto
