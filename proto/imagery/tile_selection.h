// selectTiles() finds the tiles that a view needs, so that no texel of what the view shows is larger on the screen than
// stated. Server and client select by the same rule; the server knows all tiles, and the client those that it has.
// Pure; any thread; portable to WebAssembly.
//
// Source: THEORY section 5, "Metric": texels of the size s are fine enough if s <= tau sqrt(m M). A tile is needed if,
// within the tile, the texels of its parent are not fine enough; so often only one or two of four children are needed.
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

// Ground that is nearer to the eye than this counts as if it were this far away, so that sizes on the screen are
// finite. No measurement of the value is recorded; a larger one would state texels close to the eye to be smaller than
// they are.
inline constexpr double kNearestGround_m = 0.01;

struct SelectedTile {
  TileId tile;
  // The size on the screen of the tile's largest texel, in pixels: the root of the product of both axes of its image.
  float texel_px;
  // The pixels of the screen that the tile makes finer than its parent does. A pixel counts 1 if its texel shrinks from
  // 2 pixels to 1, and less if the texel was smaller. The number is estimated from the middles of the tile's parts, and
  // is 0 if the parts are not looked at.
  float finer_px = 0;
};

// The size on the screen, in pixels, of the texels that stand in for those of a missing tile: the texels of the nearest
// coarser tile for which `has` is true. The result is infinite if there is no such tile.
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

// A TileLookup returns the bounds of a tile that exists, and nothing for other tiles. It is only asked about tiles
// within their layers.
using TileLookup = std::function<std::optional<TileBounds>(const TileId&)>;

// TilePart is a part of a tile's ground, with closer bounds than the tile's own.
struct TilePart {
  LatticeBox box;
  float lowest_m = 0, highest_m = 0;
  // The ground rises by at least and by at most this many metres a sample: along x, along y, along x and y, and along x
  // and against y.
  std::array<float, 4> min_rise_m{}, largest_rise_m{};
  // The TileGround that made the part keeps its own state here.
  uint32_t level = 0, i = 0, j = 0, splits_left = 0;
};

// TileGround knows the ground of tiles in parts, and which parts cannot be seen.
class TileGround {
 public:
  virtual ~TileGround() = default;
  // Appends the parts of an existing tile. The result is false if the tile's own bounds have to do.
  virtual bool parts(const TileId& tile, std::vector<TilePart>& out) = 0;
  // Appends the smaller parts that make up a part. The result is false if there are none.
  virtual bool split(const TilePart& part, std::vector<TilePart>& out) = 0;
  // The result is true only if it is proved that no point of the part can be seen.
  virtual bool isHidden(const TilePart& part) = 0;
};

// Replaces `out` by the tiles of a layer that `view` needs with its whole region: every tile comes after its parent,
// coarser levels come first, and the tiles of a level are in the order of their texels' size on the screen, the largest
// first. A tile that `lookup` does not know is left out with its descendants, so nothing is selected if the coarsest
// tile is unknown. At most `most` tiles are selected; the last ones in the order are left out. A tile is judged by its
// own bounds, and then by its parts if `ground` is given. O(tiles selected + parts looked at).
void selectTiles(const TileLayer& layer, uint8_t layer_index, const FrameTransform& frame, const View& view,
                 double tau_texel_px, size_t most, const TileLookup& lookup, std::vector<SelectedTile>& out,
                 TileGround* ground = nullptr);

}  // namespace foreland::proto
