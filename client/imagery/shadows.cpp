#include "client/imagery/shadows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "base/check.h"
#include "proto/imagery/relief_codec.h"

namespace foreland::client {

namespace {

constexpr int kSide = proto::kTileSide;
constexpr double kMaxCode = 65535;
constexpr uint32_t kHeightBits = 0xffff;
// A sun that stands lower casts shadows as if it stood so high.
constexpr double kLowestSun_rad = 0.008;
constexpr float kNothing = -std::numeric_limits<float>::infinity();

// How light falls over a tile: steps of one texel along the axis that leads away from the sun the most.
struct Light {
  bool along_x = true;    // the axis
  bool from_high = true;  // the sun is where the axis' texels end
  double drift = 0;       // texels across the axis for each step away from the sun
  double first_fall = 0;  // codes that light falls in the first step over the tile, and in the last
  double last_fall = 0;
  bool is_night = false;
};

// The sun over a lattice position: lattice steps a metre of level way towards it, and its height.
struct SunThere {
  glm::dvec2 towards;
  double height_rad;
};
SunThere sunAt(const proto::FrameTransform& frame, glm::dvec2 at, const glm::dvec3& sun) {
  const glm::dvec3 here = frame.toScene(proto::LatticePosition{at.x, at.y, 0});
  const glm::dvec3 x = frame.toScene(proto::LatticePosition{at.x + 1, at.y, 0}) - here;
  const glm::dvec3 y = frame.toScene(proto::LatticePosition{at.x, at.y + 1, 0}) - here;
  const double rise = glm::dot(sun, frame.upAt(here));
  const glm::dvec3 level = sun - rise * frame.upAt(here);
  const double xx = glm::dot(x, x), xy = glm::dot(x, y), yy = glm::dot(y, y), area = xx * yy - xy * xy;
  const double lx = glm::dot(level, x), ly = glm::dot(level, y);
  const glm::dvec2 towards((lx * yy - ly * xy) / area, (ly * xx - lx * xy) / area);
  return {towards / std::max(glm::length(level), 1e-9), std::asin(std::clamp(rise, -1.0, 1.0))};
}

Light lightOver(const proto::TileLayer& layer, const proto::TileId& tile, const proto::FrameTransform& frame,
                const HeightCode& code, const glm::dvec3& sun) {
  const double texel = layer.texelAt(tile.level);
  double half = 0.5 * proto::kTilePayload * texel;
  glm::dvec2 middle = layer.cornerOf(tile) + half;
  if (layer.isGlobe()) {  // within its face
    const proto::LatticeBox box = layer.boxOf(tile);
    middle = 0.5 * (box.low + box.high);
    half = 0.49 * std::min(box.high.x - box.low.x, box.high.y - box.low.y);
  }
  const SunThere there = sunAt(frame, middle, sun);
  const glm::dvec2 t = there.towards / texel;  // texels a metre
  Light light;
  light.along_x = std::abs(t.x) >= std::abs(t.y);
  const double along = light.along_x ? t.x : t.y, across = light.along_x ? t.y : t.x;
  const double most = std::max(std::abs(along), 1e-12);
  light.from_high = along > 0;
  light.drift = -across / most;
  light.is_night = there.height_rad < 0;
  const glm::dvec2 axis = (light.along_x ? glm::dvec2(1, 0) : glm::dvec2(0, 1)) * (light.from_high ? half : -half);
  const auto fallAt = [&](glm::dvec2 at) {
    return std::tan(std::max(sunAt(frame, at, sun).height_rad, kLowestSun_rad)) / most / code.step_m;
  };
  light.first_fall = fallAt(middle + axis), light.last_fall = fallAt(middle - axis);
  return light;
}

float heightOf(uint32_t texel) { return static_cast<float>(texel & kHeightBits); }
// What casts: the ground, or the light's edge above it.
float castBy(uint32_t texel) { return std::max(heightOf(texel), static_cast<float>(texel >> 16)); }

// The texels of a tile's image that lie on the raster, along x or y: those beyond it repeat its border, and are no
// ground that casts.
struct Extent {
  int low, high;  // the first and the last
  bool holds(int i) const { return i >= low && i <= high; }
};
Extent extentOf(uint32_t tile, uint32_t texels) {
  const int64_t first = int64_t{tile} * proto::kTilePayload - proto::kTileGutter;
  return {static_cast<int>(std::max<int64_t>(0, -first)),
          static_cast<int>(std::min<int64_t>(kSide, int64_t{texels} - first)) - 1};
}

// Of the parent at the middle of a tile's texel.
class Beyond {
 public:
  Beyond(const proto::TileId& tile, std::span<const uint32_t> parent, Extent columns, Extent rows)
      : parent_(parent), columns_(columns), rows_(rows) {
    const auto from = [](uint32_t t) {
      const uint32_t of_parent = t / 2;
      return 0.5 * (static_cast<double>(t) * proto::kTilePayload - proto::kTileGutter + 0.5) - 0.5 -
             (static_cast<double>(of_parent) * proto::kTilePayload - proto::kTileGutter);
    };
    x0_ = from(tile.x), y0_ = from(tile.y);
  }
  float at(double x, double y) const {
    if (parent_.empty()) return kNothing;
    const double px = std::clamp(x0_ + 0.5 * x, 0.0, kSide - 1.001), py = std::clamp(y0_ + 0.5 * y, 0.0, kSide - 1.001);
    const auto i = static_cast<size_t>(px), j = static_cast<size_t>(py);
    const auto u = static_cast<float>(px - static_cast<double>(i)), v = static_cast<float>(py - static_cast<double>(j));
    const uint32_t* p = &parent_[j * kSide + i];
    const auto mix = [&](auto cast) {
      return (cast(p[0]) * (1 - u) + cast(p[1]) * u) * (1 - v) +
             (cast(p[kSide]) * (1 - u) + cast(p[kSide + 1]) * u) * v;
    };
    const bool is_ground =
        columns_.holds(static_cast<int>(std::lround(x))) && rows_.holds(static_cast<int>(std::lround(y)));
    return is_ground ? mix(castBy) : mix([](uint32_t texel) { return static_cast<float>(texel >> 16); });
  }

 private:
  std::span<const uint32_t> parent_;
  Extent columns_, rows_;
  double x0_, y0_;
};

// Light is followed along straight lines, one for each texel across the axis, so that its edge is not smeared: `edges`
// are the heights at which it passes on each line. Lines that enter at the side begin with what the parent knows.
class Pass {
 public:
  // `along`, `across`: of the raster, on the axis of the light and on the other one.
  Pass(const Light& light, const Beyond& beyond, Extent along, Extent across, std::span<uint32_t> ground)
      : light_(light), beyond_(beyond), along_(along), across_(across), ground_(ground) {
    const double drift = light.drift * (kSide - 1);
    first_ = static_cast<int>(std::floor(std::min(0.0, -drift))) - 2;
    edges_.assign(static_cast<size_t>(kSide + std::ceil(std::abs(drift))) + 6, 0.f);
  }

  void run() {
    int begin = 0, end = 0;  // lines that have entered
    for (int n = 0; n < kSide; ++n) {
      const double moved = light_.drift * n;
      const int whole = static_cast<int>(std::floor(moved));
      const double rest = moved - whole;
      // Lines j lie at j + moved; those from a texel before the first row to one after the last count.
      const int low = -1 - whole, high = kSide - whole + 1;
      for (int j = low; j < high; ++j)
        if (n == 0 || j < begin || j >= end) edge(j) = beyond_.at(columnOf(n, j + moved), rowOf(n, j + moved));
      begin = low, end = high;
      shade(n, whole, static_cast<float>(rest));
      pass(n, whole, static_cast<float>(rest), begin, end);
    }
  }

 private:
  float& edge(int j) { return edges_[static_cast<size_t>(j - first_)]; }
  int placeOf(int n) const { return light_.from_high ? kSide - 1 - n : n; }
  double columnOf(int n, double across) const { return light_.along_x ? placeOf(n) : across; }
  double rowOf(int n, double across) const { return light_.along_x ? across : placeOf(n); }
  uint32_t& texel(int n, int across) {
    const int place = placeOf(n);
    return ground_[static_cast<size_t>(light_.along_x ? across * kSide + place : place * kSide + across)];
  }

  // Texel `row` lies between the lines row - whole - 1 and row - whole.
  void shade(int n, int whole, float rest) {
    for (int row = 0; row < kSide; ++row) {
      const float before = edge(row - whole - 1), after = edge(row - whole);
      const float height = rest == 0 ? after : after * (1 - rest) + before * rest;
      uint32_t& t = texel(n, row);
      t = (t & kHeightBits) | static_cast<uint32_t>(std::clamp(height, 0.f, 65535.f)) << 16;
    }
  }
  // To the next column of texels: above the ground of this one, and lower by what light falls.
  void pass(int n, int whole, float rest, int begin, int end) {
    const auto fall = static_cast<float>(light_.first_fall + (light_.last_fall - light_.first_fall) * n / (kSide - 1));
    for (int j = begin; j < end; ++j) {
      const int row = j + whole;
      if (along_.holds(placeOf(n)) && (across_.holds(row) || across_.holds(row + 1))) {
        const float low = heightOf(texel(n, std::clamp(row, across_.low, across_.high)));
        const float high = heightOf(texel(n, std::clamp(row + 1, across_.low, across_.high)));
        edge(j) = std::max(edge(j), low * (1 - rest) + high * rest);
      }
      edge(j) -= fall;
    }
  }

  const Light& light_;
  const Beyond& beyond_;
  Extent along_, across_;
  std::span<uint32_t> ground_;
  int first_;
  std::vector<float> edges_;
};

}  // namespace

HeightCode HeightCode::of(const proto::TileLayer& layer, double lowest_m, double highest_m) {
  // Coarser levels are rounded to larger steps.
  const double rounding_m = 0.5 * layer.stepAt(layer.levels() - 1);
  return {lowest_m - rounding_m, (highest_m - lowest_m + 2 * rounding_m) / kMaxCode + 1e-9};
}

void groundOf(const proto::TileLayer& layer, const proto::TileId& tile, const HeightCode& code,
              std::span<const int32_t> steps, std::span<uint32_t> out) {
  CHECK_EQ(steps.size(), proto::kTileTexels);
  CHECK_EQ(out.size(), steps.size());
  const double step_m = layer.stepAt(tile.level);
  for (size_t i = 0; i < steps.size(); ++i)
    out[i] = static_cast<uint32_t>(std::clamp((steps[i] * step_m - code.low_m) / code.step_m + 0.5, 0.0, kMaxCode));
}

void halfGroundOf(std::span<const uint32_t> own, std::span<uint32_t> out) {
  CHECK_EQ(own.size(), proto::kTileTexels);
  CHECK_EQ(4 * out.size(), own.size());
  for (size_t y = 0; y < kSide / 2; ++y)
    for (size_t x = 0; x < kSide / 2; ++x) {
      const uint32_t* at = &own[2 * y * kSide + 2 * x];
      const std::array<uint32_t, 4> four{at[0], at[1], at[kSide], at[kSide + 1]};
      uint32_t height = 2, shadow = 2;
      for (const uint32_t t : four) height += t & kHeightBits, shadow += t >> 16;
      out[y * (kSide / 2) + x] = height / 4 | (shadow / 4) << 16;
    }
}

void clearShadows(std::span<uint32_t> ground) {
  for (uint32_t& texel : ground) texel &= kHeightBits;
}

void castShadows(const proto::TileLayer& layer, const proto::TileId& tile, const proto::FrameTransform& frame,
                 const HeightCode& code, const glm::dvec3& sun, std::span<const uint32_t> parent,
                 std::span<uint32_t> ground) {
  CHECK_EQ(ground.size(), proto::kTileTexels);
  const Light light = lightOver(layer, tile, frame, code, sun);
  if (light.is_night) {
    for (uint32_t& texel : ground) texel |= kHeightBits << 16;
    return;
  }
  const bool has_border = !layer.isGlobe();
  const Extent all{0, kSide - 1}, columns = has_border ? extentOf(tile.x, layer.widthAt(tile.level)) : all,
                                  rows = has_border ? extentOf(tile.y, layer.heightAt(tile.level)) : all;
  const Beyond beyond(tile, parent, columns, rows);
  Pass(light, beyond, light.along_x ? columns : rows, light.along_x ? rows : columns, ground).run();
}

}  // namespace foreland::client
