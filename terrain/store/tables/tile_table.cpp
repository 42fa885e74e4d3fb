#include "terrain/store/tables/tile_table.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include "base/check.h"

namespace foreland::terrain {

namespace {

Error malformed(const char* what) { return {ErrorCode::kMalformed, what}; }

// Everything but the attribution.
Result<proto::TileLayer> layerOf(const StoredLayer& stored, uint32_t face_steps) {
  if (stored.content > 255 || stored.coding > 255 || (face_steps == 0 && stored.tiles != 0) ||
      stored.attribution_bytes > kMaxAttributionBytes)
    return malformed("a layer of tiles is damaged");
  proto::TileLayer layer;
  layer.content = static_cast<proto::TileContent>(stored.content);
  layer.coding = static_cast<proto::TileCoding>(stored.coding);
  layer.width = stored.width, layer.height = stored.height, layer.face_steps = face_steps;
  layer.origin = {stored.origin[0], stored.origin[1]};
  layer.texel = stored.texel, layer.step_m = stored.step_m;
  if (Status s = layer.validate(); !s.ok()) return s.error();
  return layer;
}

}  // namespace

Result<TileTable> TileTable::read(ByteSpan bytes, uint32_t face_steps) {
  TileTable table;
  if (bytes.empty()) return table;
  TileSectionStart start;
  if (bytes.size() < sizeof(start)) return malformed("its tiles are cut short");
  std::memcpy(&start, bytes.data(), sizeof(start));
  if (start.layers == 0 || start.layers > proto::kMaxTileLayers || start.zero != 0)
    return malformed("its tiles are of no layers or too many");
  uint64_t at = sizeof(start) + start.layers * sizeof(StoredLayer);
  if (bytes.size() < at) return malformed("its layers of tiles are cut short");
  const std::span stored(reinterpret_cast<const StoredLayer*>(bytes.data() + sizeof(start)), start.layers);
  for (const StoredLayer& s : stored) {
    auto layer = layerOf(s, face_steps);
    if (!layer) return layer.error();
    for (const proto::TileLayer& other : table.layers_)
      if (other.content == layer->content) return malformed("two layers of tiles have the same content");
    const uint64_t count = layer->isGlobe() ? s.tiles : tileCount(*layer);  // below 2^38, so nothing overflows
    if (count < layer->faces()) return malformed("a layer of tiles lacks faces");
    if (bytes.size() - at < count * sizeof(StoredTile)) return malformed("its directory of tiles is cut short");
    table.tiles_.emplace_back(reinterpret_cast<const StoredTile*>(bytes.data() + at), count);
    table.layers_.push_back(std::move(*layer));
    at += count * sizeof(StoredTile);
  }
  for (size_t i = 0; i < stored.size(); ++i) {
    if (bytes.size() - at < stored[i].attribution_bytes) return malformed("its attributions are cut short");
    table.layers_[i].attribution.assign(reinterpret_cast<const char*>(bytes.data() + at), stored[i].attribution_bytes);
    at += stored[i].attribution_bytes;
  }
  table.bytes_ = bytes;
  table.first_byte_ = at;
  return table;
}

uint64_t TileTable::directoryBytes(ByteSpan bytes, uint32_t face_steps) {
  TileSectionStart start;
  if (bytes.size() < sizeof(start)) return 0;
  std::memcpy(&start, bytes.data(), sizeof(start));
  uint64_t end = sizeof(start) + start.layers * sizeof(StoredLayer);
  if (start.layers > proto::kMaxTileLayers || bytes.size() < end) return 0;
  const std::span stored(reinterpret_cast<const StoredLayer*>(bytes.data() + sizeof(start)), start.layers);
  for (const StoredLayer& s : stored) {
    const auto layer = layerOf(s, face_steps);
    if (!layer) return 0;
    end += (layer->isGlobe() ? s.tiles : tileCount(*layer)) * sizeof(StoredTile) + s.attribution_bytes;
  }
  return end;
}

const StoredTile& TileTable::at(const proto::TileId& tile) const {
  CHECK_TRUE(tile.layer < layers_.size() && layers_[tile.layer].has(tile));
  if (layers_[tile.layer].isGlobe()) return inTree(tile);
  return tiles_[tile.layer][tileNumber(layers_[tile.layer], tile)];
}

// From the coarsest tile down, by whatever numbers are in the file.
const StoredTile& TileTable::inTree(const proto::TileId& tile) const {
  static constexpr StoredTile kNone{};
  const auto& tiles = tiles_[tile.layer];
  const uint32_t steps = layers_[tile.layer].faceBits(tile.level);
  uint64_t number = layers_[tile.layer].faceOf(tile);
  for (uint32_t left = steps; left > 0; --left) {
    const uint32_t first = tiles[number].children;
    if (first == 0) return kNone;
    number = uint64_t{first} + (tile.x >> (left - 1) & 1) + 2 * (tile.y >> (left - 1) & 1);
    if (number >= tiles.size()) return kNone;
  }
  return tiles[number];
}

// Of the tiles that are stored. Fours that are none's children are not among them.
std::vector<proto::TileId> TileTable::tree(uint8_t layer) const {
  return treeOf(layers_[layer], layer, tiles_[layer].size(),
                [&](const proto::TileId& tile) { return inTree(tile).bytes > 0; });
}

// What a server relies on, whatever the file says.
bool TileTable::isSound(const StoredTile& t) const {
  return t.bytes > 0 && t.bytes <= proto::kMaxTileBytes && t.offset >= first_byte_ && t.offset <= bytes_.size() &&
         t.bytes <= bytes_.size() - t.offset && std::isfinite(t.lowest_m) && std::isfinite(t.highest_m) &&
         t.lowest_m <= t.highest_m && t.detail >= 0 && t.detail <= 1;
}

std::optional<proto::TileBounds> TileTable::bounds(const proto::TileId& tile) const {
  const StoredTile& t = at(tile);
  if (!isSound(t)) return std::nullopt;
  return proto::TileBounds{t.lowest_m, t.highest_m, {t.axis[0], t.axis[1], t.axis[2]}, t.half_angle};
}

ByteSpan TileTable::bytes(const proto::TileId& tile) const {
  const StoredTile& t = at(tile);
  return isSound(t) ? bytes_.subspan(t.offset, t.bytes) : ByteSpan();
}

float TileTable::detail(const proto::TileId& tile) const {
  const StoredTile& t = at(tile);
  return isSound(t) ? t.detail : 0;
}

// Tiles lie in the directory's order without gaps, and none is stored whose parent is not. `end` is that of the tile
// before, and becomes that of this one.
std::string TileTable::faultOf(const proto::TileId& id, uint64_t& end) const {
  const StoredTile& t = at(id);
  if (t.bytes == 0) {
    const std::span entry(reinterpret_cast<const uint8_t*>(&t), sizeof(t));
    if (std::any_of(entry.begin(), entry.end(), [](uint8_t byte) { return byte != 0; }))
      return "is not stored, but its entry is not zero";
    return layers_[id.layer].isCoarsest(id) ? "is the coarsest, but it is not stored" : "";
  }
  if (!isSound(t) || (!layers_[id.layer].isGlobe() && t.children != 0)) return "has a damaged entry";
  if (t.offset != end) return "is not where it belongs";
  end += t.bytes;
  if (!layers_[id.layer].isCoarsest(id) && at(id.parent()).bytes == 0) return "has no parent";
  return "";
}

void TileTable::check(const std::function<void(const std::string&)>& visit) const {
  uint64_t end = first_byte_;
  for (size_t layer = 0; layer < layers_.size(); ++layer)
    if (layers_[layer].isGlobe() && tree(static_cast<uint8_t>(layer)).size() != tiles_[layer].size())
      visit("the tiles of layer " + std::to_string(layer) + " are not a tree of those that are stored");
  for (size_t layer = 0; layer < layers_.size(); ++layer)
    forEach(static_cast<uint8_t>(layer), [&](const proto::TileId& id) {
      if (const std::string what = faultOf(id, end); !what.empty()) visit(nameOf(id) + " " + what);
    });
  if (end != bytes_.size()) visit("the tiles do not fill their section");
}

std::string nameOf(const proto::TileId& id) {
  return "tile (" + std::to_string(id.x) + ", " + std::to_string(id.y) + ") of level " + std::to_string(id.level) +
         " of layer " + std::to_string(id.layer);
}

}  // namespace foreland::terrain
