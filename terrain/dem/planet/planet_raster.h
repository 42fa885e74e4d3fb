// Samples along meridians and parallels all around a body, as one surface without a seam and without holes at the
// poles. Pure; any thread.
//
// Between samples it is bilinear in longitude and latitude, around the antimeridian as elsewhere. A pole is one point,
// so it has one height: the mean of the row that is nearest to it, and beyond that row heights lead straight to it.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/dem/insets/samples.h"

namespace foreland::terrain {

class PlanetRaster {
 public:
  // Rows from the south. `first` and `step` are longitude and latitude of the first sample and from sample to sample,
  // degrees, both steps positive. Columns that go around more than once are left out. An Error says what does not reach
  // around the body, or to a pole. No sample may be a void.
  static Result<PlanetRaster> of(Samples samples, glm::dvec2 first, glm::dvec2 step);

  // Metres at a longitude and a latitude, degrees; the longitude on any turn.
  double heightAt(glm::dvec2 degrees) const;

  uint32_t columns() const { return samples_.width; }
  uint32_t rows() const { return samples_.height; }
  glm::dvec2 degreesOf(uint32_t column, uint32_t row) const {
    return {first_.x + column * (360.0 / samples_.width), first_.y + row * step_};
  }
  // Of a pole's row, all of which is the pole, the mean.
  double sampleAt(uint32_t column, uint32_t row) const { return samples_.at(column, row); }

 private:
  double alongRow(double column, uint32_t row) const;

  Samples samples_;
  glm::dvec2 first_{0, 0};
  double step_ = 1;                   // of rows
  double south_m_ = 0, north_m_ = 0;  // at the poles
};

}  // namespace foreland::terrain
