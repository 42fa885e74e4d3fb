// Colours for ground of which only heights are known: forest and meadow, rock where it is steep, scree, snow where it
// is high, with grain down to a metre. The same arguments give the same colours on any number of threads. Immutable;
// any thread. No third-party types.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

namespace foreland::terrain {

// Heights on a lattice, row by row from the south.
struct GroundHeights {
  std::span<const float> metres;  // without voids
  uint32_t width = 0, height = 0;
  glm::dvec2 spacing_m{1, 1};
};

class GroundColours {
 public:
  using Colour = std::array<uint8_t, 3>;  // sRGB

  GroundColours(const GroundHeights& ground, uint32_t seed);
  // Of positions (x + i * step, y) of the lattice, one for each of `out`. Beyond the lattice: those of its border.
  // About 0.3 microseconds a colour.
  void row(double x, double y, double step, std::span<Colour> out) const;

 private:
  struct Point {
    double height = 0, slope = 0;  // metres; tangent
  };
  Point at(double x, double y) const;
  Colour colour(const Point& point, const glm::dvec2& position_m, double texel_m) const;

  GroundHeights ground_;
  uint32_t seed_;
  double lowest_m_ = 0, range_m_ = 1;
};

}  // namespace foreland::terrain
