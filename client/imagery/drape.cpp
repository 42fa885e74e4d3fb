#include "client/imagery/drape.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <limits>

#include "base/sort.h"
#include "client/imagery/slopes.h"
#include "proto/imagery/relief_codec.h"

namespace foreland::client {

using proto::TileContent;

namespace {

// Two keyframes after `to`, if the camera goes on as it came there.
proto::View viewExpected(const proto::KeyframeHeader& from, const proto::KeyframeHeader& to) {
  proto::View view = proto::viewOf(to);
  const glm::dquat turn = to.pose.orientation * glm::conjugate(from.pose.orientation);
  view.pose.eye += 2.0 * (to.pose.eye - from.pose.eye);
  view.pose.orientation = glm::normalize(turn * turn * to.pose.orientation);
  return view;
}

}  // namespace

Drape::Drape(const TileStore& store, const Sizes& sizes) : store_(store) {
  texel_px_.fill(std::numeric_limits<double>::infinity());
  for (size_t i = 0; i < store.layers().size(); ++i) {
    const proto::TileLayer& layer = store.layers()[i];
    at(layer.content).emplace(layer, static_cast<uint8_t>(i), sizes.of(layer.content));
  }
}

void Drape::setHeights(const proto::FrameTransform& frame, double lowest_m, double highest_m) {
  frame_ = frame;
  if (const auto relief = store_.layerOf(TileContent::kRelief))
    code_ = HeightCode::of(store_.layers()[*relief], lowest_m, highest_m);
}

void Drape::setSun(const std::optional<glm::dvec3>& sun) {
  sun_ = sun;
  ++suns_;
}

const Residency* Drape::residency(TileContent content) const {
  const auto& found = residencies_[static_cast<size_t>(content)];
  return found ? &*found : nullptr;
}

void Drape::advance(const proto::FrameTransform& frame, const proto::KeyframeHeader& from,
                    const proto::KeyframeHeader& to) {
  const proto::View view = proto::viewOf(to), expected = viewExpected(from, to);
  const auto held = [&](const proto::TileId& tile) -> std::optional<proto::TileBounds> {
    const HeldTile* found = store_.find(tile);
    return found == nullptr ? std::nullopt : std::optional(found->bounds);
  };
  for (auto& residency : residencies_) {
    if (!residency) continue;
    residency->advance(frame, view, expected, held);
    for (const proto::TileId& dropped : residency->dropped()) relief_.erase(dropped.key());
  }
  measure(to.index);
  relight();
}

void Drape::measure(uint32_t keyframe) {
  const proto::TileStatement* stated = store_.statementOf(keyframe);
  texel_px_.fill(std::numeric_limits<double>::infinity());
  if (stated == nullptr) return;
  for (size_t i = 0; i < store_.layers().size(); ++i) {
    const TileContent content = store_.layers()[i].content;
    texel_px_[static_cast<size_t>(content)] = std::max(stated->texel_px[i], at(content)->texelPx());
  }
}

void Drape::relight() {
  relit_.clear();
  const Residency* relief = residency(TileContent::kRelief);
  if (relief == nullptr) return;
  for (const Residency::Arrival& arrival : relief->arrivals()) relief_.at(arrival.tile.key()).handed = suns_;
  for (const Residency::Shown& shown : relief->shown())
    if (relief_.at(shown.tile.key()).handed != suns_) relit_.push_back(shown);
  foreland::sort(relit_.begin(), relit_.end(), [](const Residency::Shown& a, const Residency::Shown& b) {
    return a.tile.level != b.tile.level ? a.tile.level > b.tile.level : a.tile.key() < b.tile.key();
  });
  if (relit_.size() > kMaxRelit) relit_.resize(kMaxRelit);
  for (const Residency::Shown& shown : relit_) relief_.at(shown.tile.key()).handed = suns_;
}

// Of what casts on a tile its parent knows the most; a tile that is drawn has one, but for the coarsest.
Drape::Relief& Drape::litRelief(const proto::TileId& tile) {
  Relief& relief = relief_.at(tile.key());
  if (relief.cast == suns_) return relief;
  relief.cast = suns_;
  if (!sun_) {
    clearShadows(relief.ground);
    return relief;
  }
  std::span<const uint32_t> beyond;
  if (relief_.contains(tile.parent().key())) beyond = litRelief(tile.parent()).ground;
  castShadows(store_.layers()[tile.layer], tile, *frame_, code_, *sun_, beyond, relief.ground);
  return relief;
}

const std::vector<uint32_t>& Drape::ground(const proto::TileId& tile) { return litRelief(tile).ground; }

const std::vector<uint32_t>& Drape::halfGround(const proto::TileId& tile) {
  half_.resize(size_t{kHalfSide} * kHalfSide);
  if (relief_.contains(tile.parent().key()))
    halfImageOf(tile, litRelief(tile.parent()).ground, half_);
  else
    halfGroundOf(ground(tile), half_);
  return half_;
}

bool Drape::decodeRelief() {
  auto& relief = at(TileContent::kRelief);
  if (!relief) return false;
  const auto tile = relief->takeWanted();
  if (!tile) return false;
  const HeldTile* held = store_.find(*tile);
  steps_.resize(proto::kTileTexels);
  if (held == nullptr) return true;
  // A tile that is damaged never becomes ready: its parent stays in its place.
  if (!proto::decodeRelief(held->coded, steps_).ok()) {
    ++damaged_;
    return true;
  }
  const proto::TileLayer& layer = store_.layers()[tile->layer];
  Relief& made = relief_[tile->key()];
  made = {};
  made.slopes.resize(proto::kTileTexels), made.ground.resize(proto::kTileTexels);
  slopesOf(layer, *tile, steps_, made.slopes);
  groundOf(layer, *tile, code_, steps_, made.ground);
  relief->setReady(*tile);
  return true;
}

const std::vector<uint32_t>& Drape::halfSlopes(const proto::TileId& tile) {
  half_.resize(size_t{kHalfSide} * kHalfSide);
  const auto parent = relief_.find(tile.parent().key());
  if (parent == relief_.end())
    halfSlopesOf(slopes(tile), half_);
  else
    halfImageOf(tile, parent->second.slopes, half_);
  return half_;
}

std::optional<proto::TileId> Drape::takeWantedImage() {
  auto& imagery = at(TileContent::kImagery);
  return imagery ? imagery->takeWanted() : std::nullopt;
}

void Drape::setImageReady(const proto::TileId& tile) {
  if (auto& imagery = at(TileContent::kImagery)) imagery->setReady(tile);
}

}  // namespace foreland::client
