// One tile of imagery before it is coded: its colours, and where no picture is. Row 0 is the southern one. Pure
// functions; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/imagery/tile.h"
#include "terrain/imagery/webp.h"
#include "terrain/picture_source.h"

namespace foreland::terrain {

// A colour in linear light and how much of its texel pictures cover, in 1/65535.
struct LinearTexel {
  uint16_t red = 0, green = 0, blue = 0, coverage = 0;
  bool operator==(const LinearTexel&) const = default;
};

LinearTexel toLinear(const Rgba& texel);  // covered if alpha is half or more
Rgba toSrgb(const LinearTexel& texel);    // alpha 255 if anything of it is covered
// The mean of four, weighted by coverage.
LinearTexel meanOf(const LinearTexel& a, const LinearTexel& b, const LinearTexel& c, const LinearTexel& d);

// Colours of a whole tile, gutters included. Texels that are not covered take a smooth mix of those that are, the
// nearer the more; grey if the tile has none.
std::vector<Rgb> filled(std::span<const Rgba> texels);

// RMS of luminance (0 to 1) over the covered texels between a tile and its parent, enlarged as a renderer does. The
// parent's colours there follow from the tile's.
float detailOf(std::span<const Rgba> texels, std::span<const Rgb> colours);

}  // namespace foreland::terrain
