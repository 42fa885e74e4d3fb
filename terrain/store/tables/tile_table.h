// The tiles of a scene file (proto/imagery/tile.h): what layers there are, and for every tile its bounds and its bytes.
// A view of the file's bytes; immutable; any thread. Looking up a tile costs the same for any number of tiles.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "proto/imagery/tile.h"
#include "terrain/store/tables/tile_section.h"

namespace foreland::terrain {

// For messages.
std::string nameOf(const proto::TileId& id);

class TileTable {
 public:
  // Of a scene without tiles.
  TileTable() = default;
  // The section's bytes, which must outlive it and be aligned to 8; no layers if there are none. An Error says what is
  // damaged. Costs the same for any number of tiles: damage of one tile makes bounds() say that it is not stored.
  // `face_steps`: of a globe the lattice steps along a side of a face, else 0.
  static Result<TileTable> read(ByteSpan bytes, uint32_t face_steps = 0);

  // How many bytes of a section there are before those of its tiles; of its start, with all StoredLayer, that is told.
  // 0 if it is damaged.
  static uint64_t directoryBytes(ByteSpan bytes, uint32_t face_steps = 0);

  std::span<const proto::TileLayer> layers() const { return layers_; }
  // Of a tile that the layer has. Nothing if it is not stored, because its parent shows the same.
  std::optional<proto::TileBounds> bounds(const proto::TileId& tile) const;
  // Its coded bytes; empty if it is not stored.
  ByteSpan bytes(const proto::TileId& tile) const;
  // How much its image differs from its parent's, enlarged: RMS of luminance, 0 to 1. Relief has 0.
  float detail(const proto::TileId& tile) const;

  // Calls visit(id) for every tile that the layer has, the finest level first and row by row from the south; on a globe
  // for those of its tree, the coarsest first.
  template <class Visit>
  void forEach(uint8_t layer, const Visit& visit) const;
  // Calls visit(what is wrong) for every fault in the directory. O(tiles).
  void check(const std::function<void(const std::string&)>& visit) const;

 private:
  const StoredTile& at(const proto::TileId& tile) const;
  const StoredTile& inTree(const proto::TileId& tile) const;
  std::vector<proto::TileId> tree(uint8_t layer) const;
  bool isSound(const StoredTile& tile) const;
  std::string faultOf(const proto::TileId& id, uint64_t& end) const;

  std::vector<proto::TileLayer> layers_;
  std::vector<std::span<const StoredTile>> tiles_;  // by layer and tileNumber
  ByteSpan bytes_;
  uint64_t first_byte_ = 0;  // of the tiles
};

template <class Visit>
void TileTable::forEach(uint8_t layer, const Visit& visit) const {
  const proto::TileLayer& l = layers_[layer];
  if (l.isGlobe()) {
    for (const proto::TileId& id : tree(layer))
      if (l.has(id)) visit(id);
    return;
  }
  for (uint32_t level = 0; level < l.levels(); ++level)
    for (uint32_t y = 0; y < l.tilesY(level); ++y)
      for (uint32_t x = 0; x < l.tilesX(level); ++x) visit(proto::TileId{layer, static_cast<uint8_t>(level), x, y});
}

}  // namespace foreland::terrain
