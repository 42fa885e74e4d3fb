// The tiles of a scene file (proto/imagery/tile.h): what layers there are, and for every tile its bounds and its bytes.
// A view of the file's bytes; immutable; any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "proto/imagery/tile.h"

namespace foreland::terrain {

class TileTable {
 public:
  // Of a scene without tiles.
  TileTable() = default;

  std::span<const proto::TileLayer> layers() const { return layers_; }
  // Of a tile that the layer has. Nothing if it is not stored, because its parent shows the same.
  std::optional<proto::TileBounds> bounds(const proto::TileId& tile) const;
  // Its coded bytes; empty if it is not stored.
  ByteSpan bytes(const proto::TileId& tile) const;
  // How much its image differs from its parent's, enlarged: RMS of luminance, 0 to 1.
  float detail(const proto::TileId& tile) const;

 private:
  std::vector<proto::TileLayer> layers_;
};

}  // namespace foreland::terrain
