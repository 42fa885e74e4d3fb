#include "terrain/epochs/epoch_layers.h"

#include <algorithm>
#include <utility>

#include "terrain/epochs/epoch_offsets.h"

namespace foreland::terrain {

EpochLayers::EpochLayers(const proto::GridTopology& grid, const proto::Frame& frame, Heights first,
                         const proto::Epochs& dates, EpochSection& section, unsigned threads)
    : grid_(grid),
      first_(first),
      threads_(threads),
      walk_({0, 0, first.width, first.height}, frame, first.quanta, dates),
      min_errors_(grid.slotCount()),
      scratch_(grid.slotCount()),
      section_(section) {}

Status EpochLayers::begin(const EpochSamples& first) {
  const Status added = section_.add(proto::Epoch{first.time, {}});
  reports_.push_back({first.date, 0, 0, section_.lastBytes()});
  return added;
}

// A node whose support reaches no row that changed has the error that it had before; what is rounded costs errors, so
// that of rounded grounds counts for nodes alone that meet the change.
Status EpochLayers::raiseErrors(const GroundAtTime& ground, const std::function<bool(double)>& keepGoing) {
  std::fill(scratch_.begin(), scratch_.end(), NodeRecord{});
  const auto store = [&](proto::Slot first, std::span<const NodeRecord> records) {
    std::copy(records.begin(), records.end(), scratch_.begin() + static_cast<std::ptrdiff_t>(first));
    for (size_t i = 0; i < records.size(); ++i)
      if (ground.rounding_m == 0 || meets(first + static_cast<proto::Slot>(i), ground.changed))
        min_errors_[first + i] = std::max(min_errors_[first + i], records[i].error());
    return true;
  };
  const bool is_complete = computeBounds({.grid = grid_,
                                          .frame = ground.frame,
                                          .heights = {ground.quanta, first_.width, first_.height},
                                          .rounding_m = ground.rounding_m,
                                          .first_row = ground.changed.y,
                                          .last_row = ground.changed.y + ground.changed.height - 1,
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

Status EpochLayers::add(const EpochSamples& epoch, const std::function<bool(double)>& keepGoing) {
  const Status moved = walk_.next(epoch, [&](const GroundAtTime& ground) { return raiseErrors(ground, keepGoing); });
  if (!moved.ok()) return moved;
  const EpochChange& change = walk_.change();
  moved_ = proto::LatticeWindow::hull(moved_, change.window);
  const auto offsets = [&](std::span<const uint32_t> rows, std::span<int32_t> out) -> Status {
    auto to = out.begin();
    for (const uint32_t y : rows)
      for (uint32_t x = moved_.x; x < moved_.x + moved_.width; ++x)
        *to++ = walk_.ground()[static_cast<size_t>(y) * first_.width + x] - first_.row(y)[x];
    return {};
  };
  const auto number = static_cast<uint32_t>(reports_.size());
  if (Status s = addEpoch(grid_, number, {epoch.time, moved_}, offsets, section_); !s.ok()) return s;
  reports_.push_back({epoch.date, change.samples, change.max_m, section_.lastBytes()});
  return {};
}

HeightRange EpochLayers::range() const {
  return {*std::ranges::min_element(walk_.lowest()), *std::ranges::max_element(walk_.highest())};
}

}  // namespace foreland::terrain
