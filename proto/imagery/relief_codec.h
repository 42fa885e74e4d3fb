// A tile of relief as bytes: heights in whole steps, without loss, predicted from those to the west and south and coded
// with what similar surroundings have had before (range_coder.h). Pure functions; any thread; portable to WebAssembly.
// Source: IMAGERY, "Shading from relief alone"; the predictor is that of LOCO-I (Weinberger et al. 2000).
#pragma once

#include <cstdint>
#include <span>

#include "base/bytes.h"
#include "base/result.h"
#include "proto/imagery/tile.h"

namespace foreland::proto {

inline constexpr uint32_t kTileTexels = kTileSide * kTileSide;
// Of a height, in steps: what a decoder makes of any bytes stays within it.
inline constexpr int32_t kMostReliefSteps = 1 << 28;

// `steps`: kTileTexels heights, row by row from the south, each within kMostReliefSteps. About 4 ms.
Bytes encodeRelief(std::span<const int32_t> steps);
// Into `steps`, which has kTileTexels. Any bytes end in heights or in an Error. About 4 ms.
Status decodeRelief(ByteSpan bytes, std::span<int32_t> steps);

}  // namespace foreland::proto
