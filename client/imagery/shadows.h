// The ground of a tile of relief as the page colours and shades it: the height of each texel, and the height below
// which it would lie in the shadow of other ground.
//
// Shadows of a tile are found in one pass over its texels, away from the sun. What lies beyond the tile casts as its
// parent knows it, which has the same from its own parent: ground is the coarser the further it is away. So the shadows
// of a tile are a function of the sun and of the tiles above it alone. They do not change when other tiles come or go,
// nor with the mesh or the tolerance. Pure; any thread; portable to WebAssembly.
#pragma once

#include <cstdint>
#include <span>

#include "proto/imagery/tile.h"
#include "proto/space/frame.h"

namespace foreland::client {

// A height as 16 bits.
struct HeightCode {
  double low_m = 0;   // of code 0
  double step_m = 1;  // from code to code
  // For all heights of a layer over ground between two heights.
  static HeightCode of(const proto::TileLayer& layer, double lowest_m, double highest_m);
};

// Ground texels: the code of the height in the low half, that of the shadow in the high half; 0: no shadow. `steps` are
// the tile's heights, as proto::decodeRelief gives them. Shadows are left out.
void groundOf(const proto::TileLayer& layer, const proto::TileId& tile, const HeightCode& code,
              std::span<const int32_t> steps, std::span<uint32_t> out);
// The half-size image of a tile that has no parent: the means of 2 x 2 of its own texels.
void halfGroundOf(std::span<const uint32_t> own, std::span<uint32_t> out);

// Fills in the shadows of a tile. `sun`: towards it, a unit vector of the scene frame. `parent`: the ground texels of
// the tile's parent with their shadows; empty if it has none. About 1 ms.
void castShadows(const proto::TileLayer& layer, const proto::TileId& tile, const proto::FrameTransform& frame,
                 const HeightCode& code, const glm::dvec3& sun, std::span<const uint32_t> parent,
                 std::span<uint32_t> ground);
// Takes them away.
void clearShadows(std::span<uint32_t> ground);

}  // namespace foreland::client
