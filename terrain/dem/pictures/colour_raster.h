// A picture along meridians and parallels, of a whole body or of a part of it, as colours at longitudes and latitudes:
// around the antimeridian as elsewhere, and without a hole at the poles, where colours lead to the mean of the row that
// is nearest. Immutable; any thread.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

#include "terrain/picture_source.h"

namespace foreland::terrain {

class ColourRaster {
 public:
  // Rows from the north, as files have them. `corner` is the longitude and latitude of the north-western corner of the
  // first pixel, `pixel` the size of one, both in degrees and positive.
  ColourRaster(std::vector<Rgba> pixels, uint32_t width, glm::dvec2 corner, glm::dvec2 pixel);

  // The mean, in linear light, over a box about a longitude and latitude, degrees, whose sides are `size` degrees long;
  // bilinear between pixels. Nothing (alpha 0) beyond the picture. O(pixels that the box holds), 256 at most.
  Rgba at(glm::dvec2 degrees, glm::dvec2 size) const;

  glm::dvec2 pixel() const { return pixel_; }
  // In pixels from the corner, x in -W/2 to W/2 of a body's whole turn about the picture's middle.
  glm::dvec2 pixelsOf(glm::dvec2 degrees) const;
  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }
  bool goesAround() const { return goes_around_; }

 private:
  struct Colour {
    float red = 0, green = 0, blue = 0, alpha = 0;  // sRGB times alpha
  };
  Colour bilinear(glm::dvec2 pixels) const;
  Colour alongRow(double x, int64_t row) const;
  Colour of(const Rgba& pixel) const;

  std::vector<Rgba> pixels_;
  uint32_t width_, height_;
  glm::dvec2 corner_, pixel_;
  bool goes_around_, has_north_, has_south_;
  Colour north_, south_;  // of the poles
};

}  // namespace foreland::terrain
