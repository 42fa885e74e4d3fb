#include "terrain/dem/insets/feather.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace foreland::terrain {

namespace {

// The least of f(j) + (step (i - j))^2 over all j, for each i: Felzenszwalb, Huttenlocher, Distance Transforms of
// Sampled Functions (2012).
class LowerEnvelope {
 public:
  void transform(std::vector<double>& f, double step) {
    const size_t n = f.size();
    places_.assign(n, 0);
    bounds_.assign(n + 1, 0);
    constexpr double kFar = std::numeric_limits<double>::infinity();
    size_t count = 0;
    for (size_t q = 0; q < n; ++q) {
      if (f[q] == kFar) continue;
      double from = -kFar;
      while (count > 0 && (from = meeting(f, step, places_[count - 1], q)) <= bounds_[count - 1]) --count;
      if (count == 0) from = -kFar;
      places_[count] = q;
      bounds_[count++] = from;
    }
    if (count == 0) return;
    before_ = f;
    for (size_t q = 0, k = 0; q < n; ++q) {
      while (k + 1 < count && bounds_[k + 1] < static_cast<double>(q)) ++k;
      const double d = step * (static_cast<double>(q) - static_cast<double>(places_[k]));
      f[q] = before_[places_[k]] + d * d;
    }
  }

 private:
  // Where the parabola of q begins to be below that of p.
  static double meeting(const std::vector<double>& f, double step, size_t p, size_t q) {
    const auto a = static_cast<double>(p), b = static_cast<double>(q);
    return ((f[q] - f[p]) / (step * step) + b * b - a * a) / (2 * (b - a));
  }
  std::vector<size_t> places_;
  std::vector<double> bounds_, before_;
};

// Whether a sample is a void, or has a neighbour that is none or is beyond the border.
bool isLast(const Samples& s, uint32_t column, uint32_t row) {
  if (column == 0 || row == 0 || column + 1 == s.width || row + 1 == s.height) return true;
  for (uint32_t y = row - 1; y <= row + 1; ++y)
    for (uint32_t x = column - 1; x <= column + 1; ++x)
      if (std::isnan(s.at(x, y))) return true;
  return false;
}

float smoothstep(double distance, double width) {
  const double t = std::clamp(distance / width, 0.0, 1.0);
  return static_cast<float>(t * t * (3 - 2 * t));
}

}  // namespace

std::vector<float> featherWeights(const Samples& samples, glm::dvec2 spacing_m, double width_m) {
  const size_t width = samples.width, height = samples.height;
  std::vector<float> out(width * height);
  if (!(width_m > 0)) {
    std::ranges::transform(samples.metres, out.begin(), [](float h) { return std::isnan(h) ? 0.f : 1.f; });
    return out;
  }
  constexpr double kFar = std::numeric_limits<double>::infinity();
  // The squares of distances fit a float as far as they count.
  LowerEnvelope envelope;
  std::vector<double> line(height);
  for (uint32_t x = 0; x < width; ++x) {
    for (uint32_t y = 0; y < height; ++y) line[y] = isLast(samples, x, y) ? 0 : kFar;
    envelope.transform(line, spacing_m.y);
    for (size_t y = 0; y < height; ++y) out[y * width + x] = static_cast<float>(line[y]);
  }
  line.resize(width);
  for (size_t y = 0; y < height; ++y) {
    for (size_t x = 0; x < width; ++x) line[x] = out[y * width + x];
    envelope.transform(line, spacing_m.x);
    for (size_t x = 0; x < width; ++x) out[y * width + x] = smoothstep(std::sqrt(line[x]), width_m);
  }
  return out;
}

double weightAt(const Samples& samples, const std::vector<float>& weights, glm::dvec2 p) {
  const auto x = static_cast<uint32_t>(std::min(std::floor(p.x), samples.width - 2.0)),
             y = static_cast<uint32_t>(std::min(std::floor(p.y), samples.height - 2.0));
  const double u = p.x - x, v = p.y - y;
  const auto at = [&](uint32_t column, uint32_t row) { return double{weights[size_t{row} * samples.width + column]}; };
  const double low = at(x, y) + u * (at(x + 1, y) - at(x, y)),
               high = at(x, y + 1) + u * (at(x + 1, y + 1) - at(x, y + 1));
  return low + v * (high - low);
}

}  // namespace foreland::terrain
