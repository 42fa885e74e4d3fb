#include "terrain/store/tables/tile_section.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "base/check.h"

namespace foreland::terrain {

namespace {

template <class T>
void putAll(std::span<const T> values, uint8_t*& at) {
  if (!values.empty()) std::memcpy(at, values.data(), values.size_bytes());
  at += values.size_bytes();
}

StoredLayer stored(const proto::TileLayer& l) {
  return {static_cast<uint32_t>(l.content),
          static_cast<uint32_t>(l.coding),
          l.width,
          l.height,
          {l.origin.x, l.origin.y},
          l.texel,
          l.step_m,
          static_cast<uint32_t>(l.attribution.size()),
          0};
}

}  // namespace

uint64_t tileCount(const proto::TileLayer& layer) {
  uint64_t count = 0;
  for (uint32_t level = 0; level < layer.levels(); ++level)
    count += uint64_t{layer.tilesX(level)} * layer.tilesY(level);
  return count;
}

uint64_t tileNumber(const proto::TileLayer& layer, const proto::TileId& tile) {
  uint64_t number = 0;
  for (uint32_t level = 0; level < tile.level; ++level) number += uint64_t{layer.tilesX(level)} * layer.tilesY(level);
  return number + uint64_t{tile.y} * layer.tilesX(tile.level) + tile.x;
}

std::vector<proto::TileId> treeOf(const proto::TileLayer& layer, uint8_t index, size_t most,
                                  const std::function<bool(const proto::TileId&)>& isStored) {
  std::vector<proto::TileId> tree;
  const auto last = static_cast<uint8_t>(layer.levels() - 1);
  for (uint32_t face = 0; face < layer.faces(); ++face) tree.push_back({index, last, face, 0});
  for (size_t i = 0; i < tree.size() && tree.size() < most; ++i) {
    const proto::TileId parent = tree[i];
    if (parent.level == 0 || !layer.has(parent) || !isStored(parent)) continue;
    const auto isChildStored = [&](uint32_t k) { return layer.has(parent.child(k)) && isStored(parent.child(k)); };
    if (!(isChildStored(0) || isChildStored(1) || isChildStored(2) || isChildStored(3))) continue;
    for (uint32_t k = 0; k < 4; ++k) tree.push_back(parent.child(k));
  }
  return tree;
}

Result<TileSection> TileSection::create(const std::filesystem::path& target) {
  auto spool = SpoolFile::create(target);
  if (!spool) return spool.error();
  return TileSection(std::move(spool).value(), target);
}

uint8_t TileSection::addLayer(const proto::TileLayer& layer) {
  CHECK_TRUE(layer.validate().ok());
  CHECK_LE(layer.attribution.size(), size_t{kMaxAttributionBytes});
  CHECK_LT(layers_.size(), size_t{proto::kMaxTileLayers});
  layers_.push_back(layer);
  tiles_.emplace_back(layer.isGlobe() ? 0 : tileCount(layer), StoredTile{});
  return static_cast<uint8_t>(layers_.size() - 1);
}

Status TileSection::add(const proto::TileId& tile, ByteSpan bytes, const proto::TileBounds& bounds, float detail) {
  CHECK_TRUE(layers_[tile.layer].has(tile) && !bytes.empty());
  if (bytes.size() > proto::kMaxTileBytes)
    return Error{ErrorCode::kLimit, "a tile of " + std::to_string(bytes.size()) + " bytes; a scene file takes " +
                                        std::to_string(proto::kMaxTileBytes)};
  const auto offset = spool_.append(bytes);
  if (!offset) return offset.error();
  const auto& a = bounds.axis;
  const StoredTile stored{*offset,
                          static_cast<uint32_t>(bytes.size()),
                          detail,
                          bounds.lowest_m,
                          bounds.highest_m,
                          {a[0], a[1], a[2]},
                          bounds.half_angle,
                          0};
  if (!layers_[tile.layer].isGlobe()) {
    tiles_[tile.layer][tileNumber(layers_[tile.layer], tile)] = stored;
    return {};
  }
  const std::lock_guard lock(sparse_->mutex);
  sparse_->tiles[tile.key()] = stored;
  return {};
}

const StoredTile* TileSection::find(const proto::TileId& tile) const {
  if (!layers_[tile.layer].isGlobe()) return &tiles_[tile.layer][tileNumber(layers_[tile.layer], tile)];
  const std::lock_guard lock(sparse_->mutex);
  const auto found = sparse_->tiles.find(tile.key());
  return found == sparse_->tiles.end() ? nullptr : &found->second;  // which stays where it is
}

std::vector<StoredTile> TileSection::directory(uint8_t index) const {
  const proto::TileLayer& layer = layers_[index];
  if (!layer.isGlobe()) return tiles_[index];
  std::vector<StoredTile> out;
  const auto isStored = [&](const proto::TileId& tile) { return has(tile); };
  const auto tree = treeOf(layer, index, std::numeric_limits<size_t>::max(), isStored);
  for (const proto::TileId& tile : tree) {
    const StoredTile* found = layer.has(tile) ? find(tile) : nullptr;
    out.push_back(found == nullptr ? StoredTile{} : *found);
  }
  // Those after the coarsest are in fours, of one parent each, in the order of the parents.
  size_t parent = 0;
  for (size_t i = layer.faces(); i < tree.size(); i += 4) {
    while (tree[parent] != tree[i].parent()) ++parent;
    out[parent].children = static_cast<uint32_t>(i);
  }
  return out;
}

proto::TileBounds TileSection::bounds(const proto::TileId& tile) const {
  const StoredTile* found = find(tile);
  const StoredTile t = found == nullptr ? StoredTile{} : *found;
  return {t.lowest_m, t.highest_m, {t.axis[0], t.axis[1], t.axis[2]}, t.half_angle};
}

uint64_t TileSection::bytes() const {
  if (layers_.empty()) return 0;
  uint64_t size = sizeof(TileSectionStart) + layers_.size() * sizeof(StoredLayer) + spool_.bytes();
  for (size_t i = 0; i < layers_.size(); ++i)
    size += directory(static_cast<uint8_t>(i)).size() * sizeof(StoredTile) + layers_[i].attribution.size();
  return size;
}

Status TileSection::write(const std::function<Status(uint64_t offset, ByteSpan what)>& put) const {
  if (layers_.empty()) return {};
  const uint64_t first_byte = bytes() - spool_.bytes();
  Bytes start_bytes(first_byte), tile_bytes;
  uint8_t* at = start_bytes.data();
  const TileSectionStart start{static_cast<uint32_t>(layers_.size()), 0};
  putAll(std::span(&start, 1), at);
  std::vector<std::vector<StoredTile>> directories;
  for (size_t i = 0; i < layers_.size(); ++i) {
    directories.push_back(directory(static_cast<uint8_t>(i)));
    StoredLayer about = stored(layers_[i]);
    if (layers_[i].isGlobe()) about.tiles = static_cast<uint32_t>(directories[i].size());
    putAll(std::span<const StoredLayer>(&about, 1), at);
  }
  uint64_t offset = first_byte;
  for (const auto& tiles : directories)
    for (StoredTile tile : tiles) {
      if (tile.bytes > 0) {
        tile_bytes.resize(tile.bytes);
        if (Status s = spool_.read(tile.offset, tile_bytes); !s.ok()) return s;
        if (Status s = put(offset, tile_bytes); !s.ok()) return s;
        tile.offset = offset;
        offset += tile.bytes;
      }
      putAll(std::span<const StoredTile>(&tile, 1), at);
    }
  for (const proto::TileLayer& layer : layers_)
    putAll(std::span(reinterpret_cast<const uint8_t*>(layer.attribution.data()), layer.attribution.size()), at);
  return put(0, start_bytes);
}

}  // namespace foreland::terrain
