// Tiles of imagery as WebP files (libwebp). Pure functions; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "base/bytes.h"
#include "base/result.h"
#include "proto/imagery/tile.h"

namespace foreland::terrain {

// sRGB.
using Rgb = std::array<uint8_t, 3>;

// A whole tile, row by row from the south, which is the first row of the file. Lossy; `quality` is 1 to 100. About 8
// ms.
Result<Bytes> encodeTile(std::span<const Rgb> pixels, int quality);
// Into a whole tile. An Error if the bytes are not a picture of its size.
Status decodeTile(ByteSpan bytes, std::span<Rgb> pixels);

}  // namespace foreland::terrain
