#include "terrain/dem/planet/planet_raster.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace foreland::terrain {

namespace {

constexpr double kNear = 1e-3;  // of a step: what files round

std::string degreesText(double degrees) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", degrees);
  return text;
}

double meanOf(const Samples& samples, uint32_t row) {
  double sum = 0;
  for (uint32_t x = 0; x < samples.width; ++x) sum += double{samples.at(x, row)};
  return sum / samples.width;
}

// Keeps the first columns.
void crop(Samples& samples, uint32_t columns) {
  for (uint32_t y = 1; y < samples.height; ++y)
    std::copy_n(samples.metres.begin() + static_cast<std::ptrdiff_t>(size_t{y} * samples.width), columns,
                samples.metres.begin() + static_cast<std::ptrdiff_t>(size_t{y} * columns));
  samples.width = columns;
  samples.metres.resize(size_t{columns} * samples.height);
}

void fillRow(Samples& samples, uint32_t row, double metres) {
  const auto begin = samples.metres.begin() + static_cast<std::ptrdiff_t>(size_t{row} * samples.width);
  std::fill_n(begin, samples.width, static_cast<float>(metres));
}

// How far on the way from the last row to the pole; the row may be the pole.
double shareOf(double beyond, double to_pole) { return beyond >= to_pole ? 1 : beyond / to_pole; }

}  // namespace

Result<PlanetRaster> PlanetRaster::of(Samples samples, glm::dvec2 first, glm::dvec2 step) {
  const double turn = std::round(360 / step.x);
  if (!(std::fabs(turn * step.x - 360) < 0.1 * step.x) || !(turn >= 3) || turn > samples.width)
    return Error{ErrorCode::kInvalidArgument, "its columns span " + degreesText(samples.width * step.x) +
                                                  " degrees in steps of " + degreesText(step.x) +
                                                  ", which does not go around a globe"};
  const double last = first.y + (samples.height - 1.0) * step.y, reach = step.y * (1 + kNear);
  if (samples.height < 2 || first.y < -90 - kNear * step.y || last > 90 + kNear * step.y || first.y > -90 + reach ||
      last < 90 - reach)
    return Error{ErrorCode::kInvalidArgument, "its rows go from " + degreesText(first.y) + " to " + degreesText(last) +
                                                  " degrees, which does not reach both poles"};
  PlanetRaster out;
  if (turn < samples.width) crop(samples, static_cast<uint32_t>(turn));
  out.south_m_ = meanOf(samples, 0);
  out.north_m_ = meanOf(samples, samples.height - 1);
  if (first.y < -90 + kNear * step.y) fillRow(samples, 0, out.south_m_);
  if (last > 90 - kNear * step.y) fillRow(samples, samples.height - 1, out.north_m_);
  out.samples_ = std::move(samples);
  out.first_ = first;
  out.step_ = step.y;
  return out;
}

double PlanetRaster::alongRow(double column, uint32_t row) const {
  const uint32_t west = std::min(static_cast<uint32_t>(column), samples_.width - 1),
                 east = west + 1 == samples_.width ? 0 : west + 1;
  const double t = column - west;
  return (1 - t) * double{samples_.at(west, row)} + t * double{samples_.at(east, row)};
}

double PlanetRaster::heightAt(glm::dvec2 degrees) const {
  const double turns = (degrees.x - first_.x) / 360, column = (turns - std::floor(turns)) * samples_.width;
  const double y = (degrees.y - first_.y) / step_, top = samples_.height - 1.0;
  if (y < 0) {
    const double t = shareOf(-y, (90 + first_.y) / step_);
    return (1 - t) * alongRow(column, 0) + t * south_m_;
  }
  if (y >= top) {
    const double t = shareOf(y - top, (90 - first_.y) / step_ - top);
    return (1 - t) * alongRow(column, samples_.height - 1) + t * north_m_;
  }
  const auto south = static_cast<uint32_t>(y);
  const double t = y - south;
  return (1 - t) * alongRow(column, south) + t * alongRow(column, south + 1);
}

}  // namespace foreland::terrain
