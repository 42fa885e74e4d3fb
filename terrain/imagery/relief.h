// Relief: the heights of a scene's samples as tiles (proto/imagery/tile.h), which ground is shaded by. Uses threads of
// its own while it runs; the result does not depend on their number. Memory: 256 rows of heights; coarser levels wait
// in a file, of 4/3 bytes a sample.
#pragma once

#include <functional>
#include <string>

#include "base/result.h"
#include "proto/imagery/tile.h"
#include "proto/space/frame.h"
#include "terrain/bounds/heights.h"
#include "terrain/store/tables/tile_section.h"

namespace foreland::terrain {

// Texels are samples. Heights are in steps of a twentieth of the distance between samples, which gives normals to
// within about two degrees, but of 10 m at most, so that they are worth looking up; rounded down to whole quanta, and
// one at least.
proto::TileLayer reliefLayer(uint32_t width, uint32_t height, const proto::Frame& frame);

// Called with the fraction that is done; returns whether to go on.
using KeepGoing = std::function<bool(double fraction)>;

// The heights of a scene's samples, however they are kept.
struct HeightRows {
  uint32_t width = 0, height = 0;  // samples
  // Fills `out` with `count` rows from `first` on, quanta. Called by one thread at a time.
  std::function<Status(uint32_t first, uint32_t count, std::span<int32_t> out)> read;

  static HeightRows of(const Heights& heights);
};

// Adds all tiles of relief to `section` as a layer; returns false if it was stopped. `frame` has the height quantum.
// A scene whose quantum is too small or too large for tiles is an Error.
Result<bool> addRelief(const HeightRows& heights, const proto::Frame& frame, unsigned threads,
                       const KeepGoing& keepGoing, TileSection& section);

}  // namespace foreland::terrain
