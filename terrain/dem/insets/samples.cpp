#include "terrain/dem/insets/samples.h"

#include <algorithm>
#include <array>
#include <limits>

namespace foreland::terrain {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// The cell of a place along one axis, and how far into it.
struct Cell {
  uint32_t first;
  double t;
};

Cell cellOf(double v, uint32_t count) {
  const double first = std::min(std::floor(v), count - 2.0);
  return {static_cast<uint32_t>(first), v - first};
}

// Catmull, Rom: A class of local interpolating splines (1974), for equal steps.
std::array<double, 4> catmullRom(double t) {
  const double t2 = t * t, t3 = t2 * t;
  return {0.5 * (-t3 + 2 * t2 - t), 0.5 * (3 * t3 - 5 * t2 + 2), 0.5 * (-3 * t3 + 4 * t2 + t), 0.5 * (t3 - t2)};
}

}  // namespace

double bilinearHeight(const Samples& samples, glm::dvec2 p) {
  if (!samples.isWithin(p)) return kNone;
  const Cell x = cellOf(p.x, samples.width), y = cellOf(p.y, samples.height);
  const auto along = [&](uint32_t row) {
    const double a = samples.at(x.first, row), b = samples.at(x.first + 1, row);
    return x.t == 0 ? a : x.t == 1 ? b : a + x.t * (b - a);
  };
  if (y.t == 0) return along(y.first);
  if (y.t == 1) return along(y.first + 1);
  const double low = along(y.first);
  return low + y.t * (along(y.first + 1) - low);
}

double cubicHeight(const Samples& samples, glm::dvec2 p) {
  const double bilinear = bilinearHeight(samples, p);
  if (std::isnan(bilinear)) return bilinear;
  const Cell x = cellOf(p.x, samples.width), y = cellOf(p.y, samples.height);
  if ((x.t == 0 || x.t == 1) && (y.t == 0 || y.t == 1)) return bilinear;
  if (x.first < 1 || y.first < 1 || x.first + 2 >= samples.width || y.first + 2 >= samples.height) return bilinear;
  const auto across = catmullRom(x.t), down = catmullRom(y.t);
  double sum = 0;
  for (uint32_t row = 0; row < 4; ++row)
    for (uint32_t column = 0; column < 4; ++column)
      sum += across[column] * down[row] * samples.at(x.first + column - 1, y.first + row - 1);
  return std::isnan(sum) ? bilinear : sum;
}

}  // namespace foreland::terrain
