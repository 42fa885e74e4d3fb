// The part of verify_tiles.h that is about relief.
#pragma once

#include "terrain/imagery/verify_tiles.h"
#include "terrain/store/file/faults.h"

namespace foreland::terrain {

LayerReport verifyRelief(const Scene& scene, uint8_t layer, unsigned threads, Faults& faults);
// That a tile's bounds hold those of the finer tiles over it.
void checkChildrensBounds(const TileTable& tiles, const proto::TileId& tile, uint64_t order, Faults& faults);

}  // namespace foreland::terrain
