// What is laid over the terrain in a scene: for relief and for imagery which tiles are drawn (residency.h), and
// relief's slopes. For a host that draws; images are decoded by the host. One owner; `store` outlives it.
#pragma once

#include <array>
#include <optional>
#include <unordered_map>
#include <vector>

#include "client/imagery/residency.h"
#include "client/imagery/tile_store.h"
#include "proto/message/compact.h"
#include "proto/space/frame.h"

namespace foreland::client {

class Drape {
 public:
  // Layers of the texture arrays.
  struct Sizes {
    uint32_t relief, imagery;
    uint32_t of(proto::TileContent content) const { return content == proto::TileContent::kRelief ? relief : imagery; }
  };

  // For the scene that `store` is in.
  Drape(const TileStore& store, const Sizes& sizes);

  // Decides what is drawn with the next mesh, which ends with this keyframe.
  void advance(const proto::FrameTransform& frame, const proto::KeyframeHeader& to);
  // nullptr if the scene has no such layer.
  const Residency* residency(proto::TileContent content) const;

  // Decodes a tile of relief that is wanted; false if none is. About 6 ms as WebAssembly.
  bool decodeRelief();
  // Of a tile of relief that arrives with the last advance(): its slopes (slopes.h), and those of its half-size image.
  const std::vector<uint32_t>& slopes(const proto::TileId& tile) const { return slopes_.at(tile.key()); }
  const std::vector<uint32_t>& halfSlopes(const proto::TileId& tile);

  // An image to be decoded by the host, and then told of; nullopt if none is wanted.
  std::optional<proto::TileId> takeWantedImage();
  void setImageReady(const proto::TileId& tile);

 private:
  std::optional<Residency>& at(proto::TileContent content) { return residencies_[static_cast<size_t>(content)]; }

  const TileStore& store_;
  std::array<std::optional<Residency>, proto::kMaxTileLayers> residencies_;  // by content
  std::unordered_map<uint64_t, std::vector<uint32_t>> slopes_;
  std::vector<uint32_t> half_slopes_;
  std::vector<int32_t> steps_;
};

}  // namespace foreland::client
