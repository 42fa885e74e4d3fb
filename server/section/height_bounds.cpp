#include "server/section/height_bounds.h"

#include <algorithm>
#include <cmath>

namespace foreland::server {

namespace {

proto::LatticeWindow movingOf(const proto::Epochs& epochs) {
  proto::LatticeWindow moving;
  for (const proto::Epoch& epoch : epochs.all()) moving = proto::LatticeWindow::hull(moving, epoch.moved);
  return moving;
}

}  // namespace

HeightBounds::HeightBounds(const Hierarchy& hierarchy)
    : table_(hierarchy.table()),
      last_x_(hierarchy.grid().shape().samples_x - 1),
      last_y_(hierarchy.grid().shape().samples_y - 1) {
  const proto::Epochs& epochs = hierarchy.epochs().epochs();
  moving_ = movingOf(epochs);
  rises_.resize(size_t{moving_.width} * moving_.height);
  hierarchy.epochs().forEachMoving(hierarchy.grid(), [&](proto::NodeId v, std::span<const int32_t> quanta) {
    const Rise* const rise = at(v);
    if (v.x() > last_x_ || v.y() > last_y_ || !rise) return;
    const auto [least, most] = epochs.range(quanta);
    rises_[static_cast<size_t>(rise - rises_.data())] = {static_cast<int32_t>(std::floor(least)),
                                                         static_cast<int32_t>(std::ceil(most))};
  });
}

// Null where nothing moves.
const HeightBounds::Rise* HeightBounds::at(proto::NodeId v) const {
  const uint32_t x = std::min(v.x(), last_x_), y = std::min(v.y(), last_y_);
  if (!moving_.contains(x, y)) return nullptr;
  return &rises_[size_t{y - moving_.y} * moving_.width + (x - moving_.x)];
}

}  // namespace foreland::server
