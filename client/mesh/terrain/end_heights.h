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
  // How far a vertex has moved since the first epoch, at the mesh's beginning (0) or its end (1); quanta.
  double moved(proto::NodeId v, size_t end) const { return offsets_ ? offsets_->at(weights_[end], v) : 0; }
  // Its height there; `height` is that of its record or of the base.
  double at(proto::NodeId v, int32_t height, size_t end) const { return height + moved(v, end); }

 private:
  const proto::EpochOffsets* offsets_ = nullptr;
  std::array<proto::EpochWeights, 2> weights_;
};

}  // namespace foreland::client
