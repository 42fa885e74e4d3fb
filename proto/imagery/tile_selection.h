// Which tiles a view needs, so that no texel of what it sees is larger on the screen than stated. Server and client
// select by the same rule: the server knows all tiles, the client those that it has. Pure; any thread; portable.
// Source: THEORY section 5, "Metric": texels of the size s are fine enough if s <= tau sqrt(m M). A tile is needed if
// those of its parent are not, within the tile: so of four children often one or two are.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "proto/imagery/tile.h"
#include "proto/space/frame.h"
#include "proto/space/view.h"

namespace foreland::proto {

// Ground nearer than this to the eye counts as if it were this far away.
inline constexpr double kNearestGround_m = 0.01;

struct SelectedTile {
  TileId tile;
  // The largest size on the screen, in pixels, of one of its texels: sqrt of the product of both axes of its image.
  float texel_px;
  // Of the screen, that the tile makes finer than its parent does: 1 counts as a pixel whose texel becomes half as
  // large, from 2 pixels to 1; finer ones count less. An estimate, from the middles of its parts; 0 if these are not
  // asked for.
  float finer_px = 0;
};

// The size on the screen, where a tile is, of the texels of the next coarser tile that there is by `has`: those that
// stand in for its own while it is missing. Infinity if there is none.
template <class Has>
float texelInPlaceOf(const SelectedTile& missing, const TileLayer& layer, const Has& has) {
  float texel_px = missing.texel_px;
  for (TileId tile = missing.tile; !layer.isCoarsest(tile);) {
    tile = tile.parent();
    texel_px *= 2;
    if (has(tile)) return texel_px;
  }
  return std::numeric_limits<float>::infinity();
}

// Knows the tiles that there are; nothing for others. Only asked about tiles that layers have.
using TileLookup = std::function<std::optional<TileBounds>(const TileId&)>;

// A part of a tile's ground, and what bounds it more closely than the tile's bounds do.
struct TilePart {
  LatticeBox box;
  float lowest_m = 0, highest_m = 0;
  // By how much the ground rises at least and at most, metres a sample: along x, along y, along x and y, along x and
  // against y.
  std::array<float, 4> min_rise_m{}, largest_rise_m{};
  // Of use to whoever made it.
  uint32_t level = 0, i = 0, j = 0, splits_left = 0;
};

// Knows the ground of tiles in parts, and which of them cannot be seen.
class TileGround {
 public:
  virtual ~TileGround() = default;
  // Appends the parts of a tile that there is. False if the tile's own bounds shall do.
  virtual bool parts(const TileId& tile, std::vector<TilePart>& out) = 0;
  // Appends smaller parts of a part; false if there are none.
  virtual bool split(const TilePart& part, std::vector<TilePart>& out) = 0;
  // False if in doubt.
  virtual bool isHidden(const TilePart& part) = 0;
};

// The tiles of a layer that `view` needs, its region taken into account, coarser ones before finer ones and with every
// tile its parent; each level's ordered by size on the screen, the largest first. Tiles that `lookup` does not know are
// left out with all that is finer; nothing if it does not know the coarsest. At most `most` tiles: finer ones are left
// out. A tile is judged by its own bounds, and then by its parts if
// there is `ground`. O(tiles selected and the parts looked at).
void selectTiles(const TileLayer& layer, uint8_t layer_index, const FrameTransform& frame, const View& view,
                 double tau_texel_px, size_t most, const TileLookup& lookup, std::vector<SelectedTile>& out,
                 TileGround* ground = nullptr);

}  // namespace foreland::proto
