#include "client/imagery/drape.h"

#include "client/imagery/slopes.h"
#include "proto/imagery/relief_codec.h"

namespace foreland::client {

using proto::TileContent;

Drape::Drape(const TileStore& store, const Sizes& sizes) : store_(store) {
  for (size_t i = 0; i < store.layers().size(); ++i) {
    const proto::TileLayer& layer = store.layers()[i];
    at(layer.content).emplace(layer, static_cast<uint8_t>(i), sizes.of(layer.content));
  }
}

const Residency* Drape::residency(TileContent content) const {
  const auto& found = residencies_[static_cast<size_t>(content)];
  return found ? &*found : nullptr;
}

void Drape::advance(const proto::FrameTransform& frame, const proto::KeyframeHeader& to) {
  const proto::View view{to.pose, to.lens, to.tau_px, to.region_radius_m, to.region_angle_rad};
  const auto held = [&](const proto::TileId& tile) -> std::optional<proto::TileBounds> {
    const HeldTile* found = store_.find(tile);
    return found == nullptr ? std::nullopt : std::optional(found->bounds);
  };
  for (auto& residency : residencies_) {
    if (!residency) continue;
    residency->advance(frame, view, held);
    for (const proto::TileId& dropped : residency->dropped()) slopes_.erase(dropped.key());
  }
}

bool Drape::decodeRelief() {
  auto& relief = at(TileContent::kRelief);
  if (!relief) return false;
  const auto tile = relief->takeWanted();
  if (!tile) return false;
  const HeldTile* held = store_.find(*tile);
  steps_.resize(proto::kTileTexels);
  // A tile that is damaged never becomes ready: its parent stays in its place.
  if (held == nullptr || !proto::decodeRelief(held->coded, steps_).ok()) return true;
  std::vector<uint32_t>& slopes = slopes_[tile->key()];
  slopes.resize(proto::kTileTexels);
  slopesOf(store_.layers()[tile->layer], *tile, steps_, slopes);
  relief->setReady(*tile);
  return true;
}

const std::vector<uint32_t>& Drape::halfSlopes(const proto::TileId& tile) {
  half_slopes_.resize(size_t{kHalfSide} * kHalfSide);
  const auto parent = slopes_.find(tile.parent().key());
  if (parent == slopes_.end())
    halfSlopesOf(slopes(tile), half_slopes_);
  else
    halfImageOf(tile, parent->second, half_slopes_);
  return half_slopes_;
}

std::optional<proto::TileId> Drape::takeWantedImage() {
  auto& imagery = at(TileContent::kImagery);
  return imagery ? imagery->takeWanted() : std::nullopt;
}

void Drape::setImageReady(const proto::TileId& tile) {
  if (auto& imagery = at(TileContent::kImagery)) imagery->setReady(tile);
}

}  // namespace foreland::client
