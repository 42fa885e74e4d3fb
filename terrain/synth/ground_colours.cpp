#include "terrain/synth/ground_colours.h"

#include <algorithm>
#include <cmath>

#include "terrain/synth/noise.h"

namespace foreland::terrain {

namespace {

using Shade = std::array<double, 3>;  // sRGB, 0 to 255

constexpr Shade kForest{58, 76, 46}, kBroadleaf{84, 98, 50}, kGap{34, 42, 30}, kMeadow{112, 124, 66},
    kDry{150, 138, 94}, kRock{122, 114, 106}, kScree{156, 148, 136}, kSnow{238, 242, 247};
constexpr double kCrown_m = 9;  // across

double step(double low, double high, double value) {
  const double t = std::clamp((value - low) / (high - low), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}
Shade mix(const Shade& a, const Shade& b, double share) {
  Shade out;
  for (size_t i = 0; i < out.size(); ++i) out[i] = a[i] + share * (b[i] - a[i]);
  return out;
}

// How many octaves reach from features of `largest_m` down to two texels.
int octavesDown(double largest_m, double texel_m) {
  return std::clamp(static_cast<int>(std::floor(std::log2(largest_m / (2 * texel_m)))) + 1, 1, 8);
}

}  // namespace

GroundColours::GroundColours(const GroundHeights& ground, uint32_t seed) : ground_(ground), seed_(seed) {
  const auto [low, high] = std::minmax_element(ground.metres.begin(), ground.metres.end());
  lowest_m_ = *low;
  range_m_ = std::max(double{*high} - *low, 1.0);
}

// Bilinear heights, and slopes between those of the samples, so that neither has an edge along the lattice.
GroundColours::Point GroundColours::at(double x, double y) const {
  const double cx = std::clamp(x, 0.0, ground_.width - 1.0), cy = std::clamp(y, 0.0, ground_.height - 1.0);
  const auto x0 = static_cast<int64_t>(cx), y0 = static_cast<int64_t>(cy);
  const double u = cx - static_cast<double>(x0), v = cy - static_cast<double>(y0);
  const auto height = [&](int64_t sx, int64_t sy) {
    const auto ax = static_cast<size_t>(std::clamp<int64_t>(sx, 0, ground_.width - 1)),
               ay = static_cast<size_t>(std::clamp<int64_t>(sy, 0, ground_.height - 1));
    return double{ground_.metres[ay * ground_.width + ax]};
  };
  const auto sample = [&](int64_t sx, int64_t sy) {
    const double gx = (height(sx + 1, sy) - height(sx - 1, sy)) / (2 * ground_.spacing_m.x),
                 gy = (height(sx, sy + 1) - height(sx, sy - 1)) / (2 * ground_.spacing_m.y);
    return Point{height(sx, sy), std::hypot(gx, gy)};
  };
  const Point a = sample(x0, y0), b = sample(x0 + 1, y0), c = sample(x0, y0 + 1), d = sample(x0 + 1, y0 + 1);
  const auto blend = [&](double Point::*of) {
    return (1 - v) * ((1 - u) * a.*of + u * b.*of) + v * ((1 - u) * c.*of + u * d.*of);
  };
  return {blend(&Point::height), blend(&Point::slope)};
}

GroundColours::Colour GroundColours::colour(const Point& point, const glm::dvec2& p, double texel_m) const {
  const auto grain = [&](double size_m, uint32_t salt) {
    return fractalNoise(p.x / size_m, p.y / size_m, seed_ + salt, {.count = octavesDown(size_m, texel_m), .gain = 0.6});
  };
  const double patches = grain(300, 0), tufts = grain(24, 20), stands = grain(900, 40);
  const double high = (point.height - lowest_m_) / range_m_ + 0.12 * patches;
  const double steep = point.slope + 0.15 * tufts;
  // Crowns with dark gaps between them, where texels are smaller than trees.
  const double crowns = fractalNoise(p.x / kCrown_m, p.y / kCrown_m, seed_ + 60, {.count = 2, .gain = 0.5}) *
                        step(0, 1, kCrown_m / texel_m - 2);
  Shade forest = mix(kForest, kBroadleaf, step(0.0, 0.35, stands + 0.4 * patches + 0.5 * crowns));
  forest = mix(forest, kGap, step(0.05, 0.6, -crowns));
  const double is_open = step(0.18, 0.3, 0.6 * patches - 0.5 * stands + 0.35 * tufts);
  Shade shade = mix(forest, kMeadow, std::max(is_open, step(0.3, 0.5, high + 0.1 * tufts)));
  shade = mix(shade, kDry, step(0.45, 0.65, high));
  const double strata = 0.5 + 0.5 * std::sin(point.height / 7 + 5 * patches);
  shade = mix(shade, mix(kScree, kRock, step(0.6, 0.9, steep)), std::max(step(0.6, 0.9, steep), step(0.6, 0.72, high)));
  const double is_bare = step(0.5, 0.9, steep);
  shade = mix(shade, kSnow, step(0.7, 0.78, high) * (1 - step(0.7, 1.1, steep)));
  const double light = 1 + 0.22 * tufts + 0.1 * patches + 0.12 * is_bare * (strata - 0.5);
  Colour out;
  for (size_t i = 0; i < out.size(); ++i)
    out[i] = static_cast<uint8_t>(std::lround(std::clamp(shade[i] * light, 0.0, 255.0)));
  return out;
}

void GroundColours::row(double x, double y, double step, std::span<Colour> out) const {
  const double texel_m = step * std::min(ground_.spacing_m.x, ground_.spacing_m.y);
  for (size_t i = 0; i < out.size(); ++i) {
    const double at_x = x + static_cast<double>(i) * step;
    out[i] = colour(at(at_x, y), glm::dvec2(at_x, y) * ground_.spacing_m, texel_m);
  }
}

}  // namespace foreland::terrain
