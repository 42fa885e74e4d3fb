// Pictures as the builder sees them: one raster of colours on the scene's lattice. Implemented by terrain/dem (files)
// and by tests. One owner, one thread at a time.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"

namespace foreland::terrain {

struct PictureInfo {
  uint32_t width = 0, height = 0;  // texels
  glm::dvec2 origin{0, 0};         // lattice position of the south-western corner of the first texel
  double texel = 1;                // sample intervals that a texel spans along x and along y
  std::vector<std::string> notes;  // what was assumed about the files, a sentence each
};

// sRGB; alpha is coverage: 0 where no picture is.
struct Rgba {
  uint8_t red = 0, green = 0, blue = 0, alpha = 0;
  bool operator==(const Rgba&) const = default;
};

// Of texels, x from the west and y from the south.
struct PictureWindow {
  uint32_t x = 0, y = 0, width = 0, height = 0;
};

class PictureSource {
 public:
  virtual ~PictureSource() = default;
  virtual const PictureInfo& info() const = 0;
  // The texels of a window within the raster, row by row from the south, into as many.
  virtual Status read(const PictureWindow& window, std::span<Rgba> out) = 0;
};

}  // namespace foreland::terrain
