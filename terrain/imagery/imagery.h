// Imagery: a picture as tiles (proto/imagery/tile.h). A texel is the mean of the four below in linear light; tiles are
// lossy WebP. Tiles whose parent, enlarged, shows nearly the same are not stored, unless finer ones over them are. Uses
// threads of its own while it runs; the result does not depend on their number.
//
// Memory: some 50 MB, and 16 bytes a tile. Coarser levels wait in files without names, 2.5 bytes a texel of the finest.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "base/result.h"
#include "proto/imagery/tile.h"
#include "terrain/imagery/ground_bounds.h"
#include "terrain/imagery/relief.h"
#include "terrain/picture_source.h"
#include "terrain/store/tables/tile_section.h"

namespace foreland::terrain {

inline constexpr int kDefaultImageryQuality = 75;
// RMS of luminance below which a tile is left out.
inline constexpr float kMinDetail = 1.5F / 255;

struct ImageryOptions {
  int quality = kDefaultImageryQuality;  // of WebP, 1 to 100
  std::string attribution;
  std::filesystem::path target;  // the scene file; temporary files are made beside it
  unsigned threads = 0;
};

// Bounds of the ground over a rectangle of the lattice; may be called by several threads at once, each with scratch of
// its own.
using BoundsOf =
    std::function<Result<proto::TileBounds>(const proto::LatticeBox& box, std::vector<glm::dvec3>& scratch)>;

struct ImageryReport {
  bool is_complete = false;  // false if it was stopped
  uint64_t tiles = 0, stored = 0;
  double covered = 0;  // share of the texels that a picture covers
};

// Adds the tiles to `section` as a layer.
Result<ImageryReport> addImagery(PictureSource& picture, const BoundsOf& boundsOf, const ImageryOptions& options,
                                 const KeepGoing& keepGoing, TileSection& section);

}  // namespace foreland::terrain
