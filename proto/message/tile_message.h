// A tile on its way to a client, and what the server states of the tiles that a client has. Both are of the kind kTile;
// their second byte tells them apart. Decoders accept any bytes. Pure functions; any thread; portable to WebAssembly.
#pragma once

#include <array>

#include "base/bytes.h"
#include "base/result.h"
#include "proto/imagery/tile.h"

namespace foreland::proto {

// Every tile comes after its parent.
struct TileMessage {
  TileId tile;
  TileBounds bounds;
  Bytes coded;  // at most kMaxTileBytes; by the layer's coding
};

// From the keyframe `keyframe` on no texel of what is in view is larger on the screen than so many pixels, by layer,
// unless the data end: infinity where nothing is guaranteed. Follows the tiles that it counts on, and goes before the
// keyframe. Of what the viewer holds; what it does not draw yet it counts itself.
struct TileStatement {
  uint32_t keyframe = 0;
  std::array<float, kMaxTileLayers> texel_px{};
};

Bytes encode(const TileMessage& message);
Bytes encode(const TileStatement& message);
// Messages of kind kTile.
bool isTileStatement(ByteSpan bytes);
Result<TileMessage> decodeTile(ByteSpan bytes);
Result<TileStatement> decodeTileStatement(ByteSpan bytes);

}  // namespace foreland::proto
