#include "terrain/dem/pictures/colour_raster.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "terrain/srgb.h"

namespace foreland::terrain {

namespace {

constexpr double kMostSamples = 16;      // along each side of a box
constexpr double kRoundingShare = 1e-6;  // of a pixel or a body: what rounding leaves

const std::array<float, 256>& linear() {
  static const auto table = [] {
    std::array<float, 256> t{};
    for (size_t i = 0; i < t.size(); ++i) t[i] = static_cast<float>(linearOfSrgb(static_cast<double>(i) / 255));
    return t;
  }();
  return table;
}

float linearOf(float srgb) {
  const float at = std::clamp(srgb, 0.F, 255.F);
  const auto i = std::min(static_cast<size_t>(at), size_t{254});
  return linear()[i] + (linear()[i + 1] - linear()[i]) * (at - static_cast<float>(i));
}
uint8_t byteOf(float value) { return static_cast<uint8_t>(std::lround(std::clamp(value, 0.F, 255.F))); }

template <class Colour>
Colour mixed(const Colour& a, const Colour& b, double t) {
  const auto v = static_cast<float>(t), u = 1 - v;
  return {a.red * u + b.red * v, a.green * u + b.green * v, a.blue * u + b.blue * v, a.alpha * u + b.alpha * v};
}

}  // namespace

ColourRaster::ColourRaster(std::vector<Rgba> pixels, uint32_t width, glm::dvec2 corner, glm::dvec2 pixel)
    : pixels_(std::move(pixels)),
      width_(width),
      height_(static_cast<uint32_t>(pixels_.size() / width)),
      corner_(corner),
      pixel_(pixel),
      goes_around_(std::abs(width * pixel.x - 360) < kRoundingShare * 360 + 0.01 * pixel.x),
      has_north_(goes_around_ && corner.y > 90 - pixel.y),
      has_south_(goes_around_ && corner.y - height_ * pixel.y < -90 + pixel.y) {
  const auto meanOf = [&](uint32_t row) {
    Colour sum;
    for (uint32_t x = 0; x < width_; ++x) {
      const Colour c = of(pixels_[size_t{row} * width_ + x]);
      sum.red += c.red, sum.green += c.green, sum.blue += c.blue, sum.alpha += c.alpha;
    }
    const float share = 1 / static_cast<float>(width_);
    return Colour{sum.red * share, sum.green * share, sum.blue * share, sum.alpha * share};
  };
  north_ = meanOf(0), south_ = meanOf(height_ - 1);
}

glm::dvec2 ColourRaster::pixelsOf(glm::dvec2 degrees) const {
  const double middle = corner_.x + 0.5 * width_ * pixel_.x;
  const double east = degrees.x - middle;
  return {0.5 * width_ + (east - 360 * std::round(east / 360)) / pixel_.x, (corner_.y - degrees.y) / pixel_.y};
}

ColourRaster::Colour ColourRaster::of(const Rgba& p) const {
  const float alpha = static_cast<float>(p.alpha) / 255;
  return {static_cast<float>(p.red) * alpha, static_cast<float>(p.green) * alpha, static_cast<float>(p.blue) * alpha,
          alpha};
}

// `x` in pixels from the middle of the first.
ColourRaster::Colour ColourRaster::alongRow(double x, int64_t row) const {
  if (row < 0 && has_north_) return north_;
  if (row >= height_ && has_south_) return south_;
  const int64_t width = width_;
  const auto at = [&](int64_t i) {
    i = goes_around_ ? (i % width + width) % width : std::clamp<int64_t>(i, 0, width - 1);
    const int64_t j = std::clamp<int64_t>(row, 0, int64_t{height_} - 1);
    return of(pixels_[static_cast<size_t>(j * width + i)]);
  };
  const auto first = static_cast<int64_t>(std::floor(x));
  return mixed(at(first), at(first + 1), x - static_cast<double>(first));
}

ColourRaster::Colour ColourRaster::bilinear(glm::dvec2 p) const {
  const bool is_within =
      (goes_around_ || (p.x >= 0 && p.x <= width_)) && (has_north_ || p.y >= 0) && (has_south_ || p.y <= height_);
  if (!is_within) return {};
  const double y = p.y - 0.5;
  const auto row = static_cast<int64_t>(std::floor(y));
  double t = y - static_cast<double>(row);
  // The poles are half a pixel beyond the rows next to them, at most.
  if (row < 0 && has_north_)
    t = std::clamp(1 + y / std::max(0.5 + (90 - corner_.y) / pixel_.y, kRoundingShare), 0.0, 1.0);
  if (row + 1 >= height_ && has_south_) {
    const double last = corner_.y - (height_ - 0.5) * pixel_.y;
    t = std::clamp((y - (height_ - 1.0)) / std::max((last + 90) / pixel_.y, kRoundingShare), 0.0, 1.0);
  }
  return mixed(alongRow(p.x - 0.5, row), alongRow(p.x - 0.5, row + 1), t);
}

Rgba ColourRaster::at(glm::dvec2 degrees, glm::dvec2 size) const {
  const auto samples = [](double pixels) { return std::clamp(std::ceil(pixels - 0.5), 1.0, kMostSamples); };
  const double columns = samples(size.x / pixel_.x), rows = samples(size.y / pixel_.y);
  const glm::dvec2 middle = pixelsOf(degrees);
  float red = 0, green = 0, blue = 0, alpha = 0;
  Colour c;
  for (double j = 0; j < rows; ++j)
    for (double i = 0; i < columns; ++i) {
      const glm::dvec2 off = ((glm::dvec2(i, j) + 0.5) / glm::dvec2(columns, rows) - 0.5) * (size / pixel_);
      c = bilinear(middle + off);
      if (c.alpha <= 0) continue;
      red += c.alpha * linearOf(c.red / c.alpha), green += c.alpha * linearOf(c.green / c.alpha);
      blue += c.alpha * linearOf(c.blue / c.alpha), alpha += c.alpha;
    }
  if (alpha <= 0) return {};
  const auto part = [&](float sum) {
    return byteOf(255 * static_cast<float>(srgbOfLinear(double{sum} / double{alpha})));
  };
  const uint8_t coverage = byteOf(255 * alpha / static_cast<float>(columns * rows));
  if (rows * columns == 1)
    return {byteOf(c.red / c.alpha), byteOf(c.green / c.alpha), byteOf(c.blue / c.alpha), coverage};
  return {part(red), part(green), part(blue), coverage};
}

}  // namespace foreland::terrain
