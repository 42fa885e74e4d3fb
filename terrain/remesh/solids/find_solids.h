// Looks for convex solids inside a closed surface that may hide what is behind them (terrain/surface/inner_solids.h).
//
// A solid's planes have fixed directions: those of the walls, floors and roofs that most of the surface faces. From a
// point deep inside, triangles are taken from the nearest on: one that no plane keeps out yet is kept out by the plane
// that may stay farthest from the point. Then each plane in turn moves out until a triangle that no other plane keeps
// out stops it. Points are tried from the deepest on that no solid holds yet; the four solids that together hold most
// of the surface's volume are kept.
#pragma once

#include <cstdint>
#include <string>

#include "terrain/surface/inner_solids.h"

namespace foreland::terrain {

struct SolidsFound {
  InnerSolids inner;
  std::string why_none;  // if there are no solids: the reason, to be told after "no inner solids: "
};

// Solids of a thickness of at least kMinSolidThickness, each proved by isInside. The same surface gives the same
// solids. Cost: about a second up to 10^5 triangles, some seconds at kMaxSolidTriangles, beyond which none are looked
// for.
[[nodiscard]] SolidsFound findSolids(const TrueSurface& surface);

inline constexpr double kMinSolidThickness =
    1.0 / 32;  // of the diagonal of the surface's box; thinner ones hide little
inline constexpr uint64_t kMaxSolidTriangles = 1u << 22;

}  // namespace foreland::terrain
