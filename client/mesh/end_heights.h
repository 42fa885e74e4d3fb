// The heights of vertices at the two ends of a mesh: those of the records, and in scenes with epochs as far as the
// ground has moved by the scene time of either end (proto/section/epochs.h). A view; one owner.
#pragma once

#include <array>

#include "proto/section/epoch_offsets.h"

namespace foreland::client {

class EndHeights {
 public:
  // Of ground that does not move.
  EndHeights() = default;
  // `offsets` must outlive it.
  EndHeights(const proto::EpochOffsets& offsets, Time from, Time to)
      : offsets_(&offsets), weights_{offsets.epochs().weightsAt(from), offsets.epochs().weightsAt(to)} {}

  bool isMoving() const { return offsets_ != nullptr; }
  // Quanta, at the mesh's beginning (0) or its end (1); `height` is that of the vertex's record or of the base.
  double at(proto::NodeId v, int32_t height, size_t end) const {
    return offsets_ ? height + offsets_->at(weights_[end], v) : height;
  }

 private:
  const proto::EpochOffsets* offsets_ = nullptr;
  std::array<proto::EpochWeights, 2> weights_;
};

}  // namespace foreland::client
