// The samples of one elevation raster as plain data, and its surface between them. Pure; any thread.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

namespace foreland::terrain {

struct Samples {
  uint32_t width = 0, height = 0;
  std::vector<float> metres;  // row by row; NaN where there is no data

  float at(uint32_t column, uint32_t row) const { return metres[size_t{row} * width + column]; }
  bool isWithin(glm::dvec2 p) const { return p.x >= 0 && p.y >= 0 && p.x <= width - 1.0 && p.y <= height - 1.0; }
};

// Heights at a column and row between the samples; NaN beyond these, and where a sample that counts is a void. A
// sample's own place has its height to the bit.
//   bilinear  of the four around it
//   cubic     Catmull-Rom's, of sixteen; where not all of these have data, bilinear
double bilinearHeight(const Samples& samples, glm::dvec2 p);
double cubicHeight(const Samples& samples, glm::dvec2 p);

// The surface that is drawn of heights on a lattice at full resolution: two triangles for each cell, whose diagonal
// joins the corners whose x + y is even (proto/topology/grid.h). So what bisection makes of a coarser lattice without
// errors is this surface of it. `at(x, y)` is a height, `last` the last position, (x, y) a position up to it. NaN if a
// corner that counts is.
template <class At>
double drawnHeight(glm::uvec2 last, glm::dvec2 p, const At& at) {
  const auto cell = [](double v, uint32_t end) {
    return static_cast<uint32_t>(std::fmin(std::floor(v), static_cast<double>(end) - 1));
  };
  const uint32_t x = cell(p.x, last.x), y = cell(p.y, last.y);
  const double u = p.x - x, v = p.y - y;
  const auto between = [](double a, double b, double t) { return t == 0 ? a : t == 1 ? b : a + t * (b - a); };
  if (v == 0 || v == 1) {
    const uint32_t row = y + (v == 1);
    return u == 0 ? at(x, row) : u == 1 ? at(x + 1, row) : between(at(x, row), at(x + 1, row), u);
  }
  if (u == 0 || u == 1) return between(at(x + (u == 1), y), at(x + (u == 1), y + 1), v);
  if ((x + y) % 2 == 0) {
    const double a = at(x, y), d = at(x + 1, y + 1);
    if (u == v) return between(a, d, u);
    const double other = u > v ? at(x + 1, y) : at(x, y + 1);
    return u > v ? a + u * (other - a) + v * (d - other) : a + v * (other - a) + u * (d - other);
  }
  const double b = at(x + 1, y), c = at(x, y + 1);
  if (u + v == 1) return between(b, c, v);
  if (u + v < 1) {
    const double a = at(x, y);
    return a + u * (b - a) + v * (c - a);
  }
  const double d = at(x + 1, y + 1);
  return d + (1 - u) * (c - d) + (1 - v) * (b - d);
}

}  // namespace foreland::terrain
