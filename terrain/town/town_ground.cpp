#include "terrain/town/town_ground.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "terrain/synth/landscape.h"

namespace foreland::terrain {

namespace {

constexpr double kRolling = 0.06;  // what is left of the relief in the plain
constexpr double kFoot_m = 350;    // from the plain's rim to where the mountains are as they were

}  // namespace

Result<std::unique_ptr<TownGround>> TownGround::create(const TownGroundOptions& options) {
  const auto size = static_cast<uint32_t>(std::lround(options.side_m / options.spacing_m)) + 1;
  const auto land = Landscape::create({.size = size, .spacing_m = options.spacing_m, .seed = options.seed});
  if (!land.ok()) return land.error();
  std::unique_ptr<TownGround> ground(new TownGround);
  ground->info_ = (*land)->info();
  ground->info_.title = "synthetic town, seed " + std::to_string(options.seed);
  ground->heights_.resize(size_t{size} * size);
  (*land)->heights(0, size, ground->heights_);
  ground->flatten(options);
  return ground;
}

glm::dvec2 TownGround::middle() const { return info_.frame.map_origin_m; }

void TownGround::flatten(const TownGroundOptions& options) {
  const double middle = (info_.width - 1) / 2.0;
  const auto distance = [&](uint32_t x, uint32_t y) { return options.spacing_m * std::hypot(x - middle, y - middle); };
  double sum = 0, count = 0;
  for (uint32_t y = 0; y < info_.height; ++y)
    for (uint32_t x = 0; x < info_.width; ++x)
      if (distance(x, y) <= options.plain_radius_m) sum += heights_[size_t{y} * info_.width + x], ++count;
  const double mean = count > 0 ? sum / count : 0;
  for (uint32_t y = 0; y < info_.height; ++y)
    for (uint32_t x = 0; x < info_.width; ++x) {
      const double t = std::clamp((distance(x, y) - options.plain_radius_m) / kFoot_m, 0.0, 1.0);
      const double share = kRolling + (1 - kRolling) * t * t * (3 - 2 * t);
      float& height = heights_[size_t{y} * info_.width + x];
      height = static_cast<float>(mean + share * (height - mean));
    }
}

Status TownGround::readRows(uint32_t first, uint32_t count, std::span<float> out) {
  CHECK_LE(uint64_t{first} + count, info_.height);
  CHECK_EQ(out.size(), size_t{count} * info_.width);
  std::copy_n(heights_.begin() + static_cast<ptrdiff_t>(size_t{first} * info_.width), out.size(), out.begin());
  return {};
}

}  // namespace foreland::terrain
