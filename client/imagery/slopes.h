// Relief as the page shades by it: slopes, from the heights of a tile. Pure; any thread; portable to WebAssembly.
#pragma once

#include <cstdint>
#include <span>

#include "proto/imagery/relief_codec.h"
#include "proto/imagery/tile.h"

namespace foreland::client {

// Of each texel two half floats, the one along x in the low bits: metres that the ground rises a sample interval along
// the lattice's x, and y. By central differences, one-sided at the borders. `steps` are the tile's heights, as
// proto::decodeRelief gives them; `out` has as many elements.
void slopesOf(const proto::TileLayer& layer, const proto::TileId& tile, std::span<const int32_t> steps,
              std::span<uint32_t> out);

// Side of the half-size image of a tile, and where it lies in its parent's image: the column, or row, of its first
// texel if the tile's x, or y, is this.
inline constexpr uint32_t kHalfSide = proto::kTileSide / 2;
constexpr uint32_t halfImageAt(uint32_t x) { return proto::kTileGutter / 2 + x % 2 * (proto::kTilePayload / 2); }

// The half-size image of a tile, which is a part of its parent's: kHalfSide * kHalfSide elements.
void halfImageOf(const proto::TileId& tile, std::span<const uint32_t> parent, std::span<uint32_t> out);
// And of a tile that has no parent: the means of 2 x 2 of its own slopes.
void halfSlopesOf(std::span<const uint32_t> own, std::span<uint32_t> out);

}  // namespace foreland::client
