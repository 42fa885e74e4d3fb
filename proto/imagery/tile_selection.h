// Which tiles a view needs, so that no texel of what it sees is larger on the screen than stated. Server and client
// select by the same rule: the server knows all tiles, the client those that it has. Pure; any thread; portable.
// Source: IMAGERY, "Metric": texels of the size s are fine enough if s <= tau sqrt(m M). A tile is needed if those of
// its parent are not, within the tile: so of four children often one or two are.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "proto/imagery/tile.h"
#include "proto/space/frame.h"
#include "proto/space/view.h"

namespace foreland::proto {

struct SelectedTile {
  TileId tile;
  // The largest size on the screen, in pixels, of one of its texels: sqrt of the product of both axes of its image.
  float texel_px;
};

// Knows the tiles that there are; nothing for others. Only asked about tiles that layers have.
using TileLookup = std::function<std::optional<TileBounds>(const TileId&)>;

// The tiles of a layer that `view` needs, its region taken into account, coarser ones before finer ones and with every
// tile its parent; each level's ordered by size on the screen, the largest first. Tiles that `lookup` does not know are
// left out with all that is finer; nothing if it does not know the coarsest. At most `most` tiles: finer ones are left
// out. O(tiles selected).
void selectTiles(const TileLayer& layer, uint8_t layer_index, const FrameTransform& frame, const View& view,
                 double tau_texel_px, size_t most, const TileLookup& lookup, std::vector<SelectedTile>& out);

}  // namespace foreland::proto
