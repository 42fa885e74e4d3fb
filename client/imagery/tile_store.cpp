#include "client/imagery/tile_store.h"

#include <string>
#include <utility>

namespace foreland::client {

void TileStore::enter(std::vector<proto::TileLayer> layers, uint32_t max_bytes) {
  layers_ = std::move(layers);
  memory_ = proto::TileMemory(max_bytes);
  tiles_.clear();
  statement_.reset(), earlier_statement_.reset();
  received_ = 0;
  ++scene_;
}

void TileStore::reenter(uint32_t max_bytes) {
  const proto::TileMemory before = std::exchange(memory_, proto::TileMemory(max_bytes));
  before.visit([&](const proto::TileId& tile, uint32_t bytes) { remember(tile, bytes); });
  statement_.reset(), earlier_statement_.reset();
}

void TileStore::remember(const proto::TileId& tile, uint32_t bytes) {
  memory_.add(tile, bytes, [&](const proto::TileId& dropped) { tiles_.erase(dropped.key()); });
}

Status TileStore::add(proto::TileMessage message) {
  const proto::TileId& t = message.tile;
  if (t.layer >= layers_.size() || !layers_[t.layer].has(t))
    return Error{ErrorCode::kMalformed, "a tile that the scene does not have: layer " + std::to_string(t.layer) +
                                            ", level " + std::to_string(t.level) + ", " + std::to_string(t.x) + ", " +
                                            std::to_string(t.y)};
  const auto bytes = static_cast<uint32_t>(message.coded.size());
  tiles_[t.key()] = {message.bounds, std::move(message.coded)};
  remember(t, bytes);
  ++received_;
  return {};
}

// It comes before the keyframe from which on it holds, maybe a good while.
void TileStore::add(const proto::TileStatement& statement) {
  earlier_statement_ = std::exchange(statement_, statement);
}

const proto::TileStatement* TileStore::statementOf(uint32_t keyframe) const {
  for (const auto* each : {&statement_, &earlier_statement_})
    if (*each && (*each)->keyframe <= keyframe) return &**each;
  return nullptr;
}

std::optional<uint8_t> TileStore::layerOf(proto::TileContent content) const {
  for (size_t i = 0; i < layers_.size(); ++i)
    if (layers_[i].content == content) return static_cast<uint8_t>(i);
  return std::nullopt;
}

const HeldTile* TileStore::find(const proto::TileId& tile) const {
  const auto it = tiles_.find(tile.key());
  return it == tiles_.end() ? nullptr : &it->second;
}

proto::HeldTiles TileStore::held() const {
  proto::HeldTiles out;
  memory_.visit([&](const proto::TileId& tile, uint32_t) { out.tiles.push_back(tile); });
  return out;
}

}  // namespace foreland::client
