// The coded tiles that a client holds, under the rule by which the server knows them (proto/imagery/tile_memory.h), and
// what the server has stated of them. One owner.
#pragma once

#include <optional>
#include <unordered_map>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "proto/imagery/tile.h"
#include "proto/imagery/tile_memory.h"
#include "proto/message/message.h"

namespace foreland::client {

struct HeldTile {
  proto::TileBounds bounds;
  Bytes coded;
};

class TileStore {
 public:
  // Enters a scene with these layers; what was held before is dropped.
  void enter(std::vector<proto::TileLayer> layers, uint32_t max_bytes);
  // Enters the same scene on a new connection, which may allow less memory.
  void reenter(uint32_t max_bytes);

  // An Error if the scene has no such tile.
  Status add(proto::TileMessage message);
  void add(const proto::TileStatement& statement);

  const std::vector<proto::TileLayer>& layers() const { return layers_; }
  // The layer of a content, by its number; nullopt if the scene has none.
  std::optional<uint8_t> layerOf(proto::TileContent content) const;
  // Valid until the next call of a member that is not const; nullptr if the tile is not held.
  const HeldTile* find(const proto::TileId& tile) const;
  // All that is held, the oldest first.
  proto::HeldTiles held() const;
  // The one that holds for a keyframe, which must be the last one or the one before; nullptr if there is none.
  const proto::TileStatement* statementOf(uint32_t keyframe) const;

  // Counts scenes that were entered.
  uint32_t scene() const { return scene_; }
  size_t count() const { return memory_.count(); }
  uint64_t bytes() const { return memory_.bytes(); }
  // Counts all tiles that came in this scene.
  uint64_t received() const { return received_; }

 private:
  void remember(const proto::TileId& tile, uint32_t bytes);

  std::vector<proto::TileLayer> layers_;
  proto::TileMemory memory_{0};
  std::unordered_map<uint64_t, HeldTile> tiles_;
  std::optional<proto::TileStatement> statement_, earlier_statement_;
  uint64_t received_ = 0;
  uint32_t scene_ = 0;
};

}  // namespace foreland::client
