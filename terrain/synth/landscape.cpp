#include "terrain/synth/landscape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "base/check.h"
#include "base/rng.h"
#include "terrain/synth/erosion.h"
#include "terrain/synth/noise.h"

namespace foreland::terrain {

namespace {

constexpr double kMargin = 0.125;  // of the landscape's side
constexpr uint32_t kMaxGrid = 1281;
constexpr uint32_t kCoarsest = 161;  // cells a side at which the rivers find their way
constexpr double kLowest_m = 200, kMaxRelief_m = 2800;
constexpr double kSteepness = 0.16;        // relief over side for small landscapes
constexpr double kTalus = 0.6;             // 31 degrees
constexpr double kUpliftPerRelief = 0.25;  // gives about the wanted relief with an erodibility of 1
constexpr uint32_t kMaxSize = 1u << 20;

// Where the ground rises, 0 to 1, over the unit square: ranges and basins of a few to the side.
double upliftAt(double x, double y, uint32_t seed) {
  const double wx = x + 0.14 * fractalNoise(2.1 * x, 2.1 * y, seed + 11, {.count = 5, .gain = 0.55});
  const double wy = y + 0.14 * fractalNoise(2.1 * x, 2.1 * y, seed + 23, {.count = 5, .gain = 0.55});
  const double ridge = std::max(0.0, 1 - std::fabs(2.2 * noise(1.9 * wx, 1.9 * wy, seed + 31)));
  const double t = std::clamp(0.6 + 1.3 * fractalNoise(1.7 * wx, 1.7 * wy, seed + 41, {.count = 3}), 0.0, 1.0);
  const double swell = t * t * (3 - 2 * t);
  const double rough = 0.5 + 0.5 * fractalNoise(7 * wx, 7 * wy, seed + 53, {.count = 4, .gain = 0.6});
  return std::clamp(0.03 + swell * (0.35 + 0.65 * ridge * ridge) * (0.6 + 0.8 * rough), 0.03, 1.2);
}

void setUplift(ErosionGrid& grid, double steepest, uint32_t seed) {
  const uint32_t n = grid.size;
  grid.uplift.assign(size_t{n} * n, 0.0f);
  for (uint32_t y = 1; y + 1 < n; ++y)
    for (uint32_t x = 1; x + 1 < n; ++x)
      grid.uplift[size_t{y} * n + x] = static_cast<float>(steepest * upliftAt(x / (n - 1.0), y / (n - 1.0), seed));
}

// What the rivers find when they begin: swells with fractal hills on them, so that their courses owe nothing to the
// grid.
void setYoungMountains(ErosionGrid& grid, double relief, uint32_t seed) {
  const uint32_t n = grid.size;
  grid.height.resize(size_t{n} * n);
  for (uint32_t y = 0; y < n; ++y)
    for (uint32_t x = 0; x < n; ++x) {
      const double u = x / (n - 1.0), v = y / (n - 1.0), lift = upliftAt(u, v, seed);
      const double hills = fractalNoise(5 * u, 5 * v, seed + 71, {.count = 7, .gain = 0.55});
      grid.height[size_t{y} * n + x] = static_cast<float>(relief * (0.5 * lift + (0.1 + 0.25 * lift) * hills));
    }
}

// Small unevenness, so that rivers bend and branch.
void roughen(ErosionGrid& grid, double amplitude_m, uint32_t seed) {
  for (uint32_t y = 0; y < grid.size; ++y)
    for (uint32_t x = 0; x < grid.size; ++x)
      grid.height[size_t{y} * grid.size + x] += static_cast<float>(
          amplitude_m * fractalNoise(0.19 * x, 0.19 * y, seed + grid.size, {.count = 3, .gain = 0.7}));
}

// Finer, and bent a little: ridges and rivers lose the eight directions that the coarse grid gave them.
ErosionGrid refined(const ErosionGrid& coarse, uint32_t size, uint32_t seed) {
  ErosionGrid fine{.size = size, .cell = coarse.cell * (coarse.size - 1) / (size - 1), .height = {}, .uplift = {}};
  fine.height.resize(size_t{size} * size);
  const double ratio = (coarse.size - 1.0) / (size - 1.0);
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      const double along = x * ratio, across = y * ratio;
      const double u = std::clamp(along + 4 * fractalNoise(along / 11, across / 11, seed + size, {.count = 3}), 0.0,
                                  coarse.size - 1.0);
      const double v = std::clamp(across + 4 * fractalNoise(along / 11, across / 11, seed + size + 9, {.count = 3}),
                                  0.0, coarse.size - 1.0);
      const auto i = std::min(static_cast<uint32_t>(u), coarse.size - 2),
                 j = std::min(static_cast<uint32_t>(v), coarse.size - 2);
      const double s = u - i, t = v - j;
      const float* h = coarse.height.data() + size_t{j} * coarse.size + i;
      fine.height[size_t{y} * size + x] = static_cast<float>(
          (h[0] * (1 - s) + h[1] * s) * (1 - t) + (*(h + coarse.size) * (1 - s) + *(h + coarse.size + 1) * s) * t);
    }
  return fine;
}

// Catmull-Rom weights and their derivative at t between the second and third of four points.
struct Cubic {
  std::array<double, 4> value, slope;
  explicit Cubic(double t)
      : value{0.5 * t * (t * (2 - t) - 1), 0.5 * (t * t * (3 * t - 5) + 2), 0.5 * t * (t * (4 - 3 * t) + 1),
              0.5 * t * t * (t - 1)},
        slope{0.5 * (t * (4 - 3 * t) - 1), 0.5 * t * (9 * t - 10), 0.5 * (t * (8 - 9 * t) + 1), 0.5 * t * (3 * t - 2)} {
  }
};

double reliefFor(double side_m) { return std::min(kMaxRelief_m, kSteepness * side_m); }

}  // namespace

Result<std::unique_ptr<Landscape>> Landscape::create(const LandscapeOptions& options) {
  if (options.size < 2 || options.size > kMaxSize)
    return Error{ErrorCode::kInvalidArgument,
                 "a landscape of size " + std::to_string(options.size) + "; 2 to 1048576 samples a side can be made"};
  if (!(options.spacing_m > 0) || !(options.spacing_m <= 1e6))
    return Error{ErrorCode::kInvalidArgument,
                 "a spacing of " + std::to_string(options.spacing_m) + " m; it must be positive, at most 1000 km"};
  return std::unique_ptr<Landscape>(new Landscape(options));
}

Landscape::Landscape(const LandscapeOptions& options)
    : options_(options), seed_(static_cast<uint32_t>(Rng(options.seed).next())) {
  info_.width = info_.height = options.size;
  info_.frame.axis_x_m = {options.spacing_m, 0};
  info_.frame.axis_y_m = {0, options.spacing_m};
  info_.frame.anchor = {options.size / 2, options.size / 2};
  info_.frame.map_origin_m = info_.frame.anchor * options.spacing_m;
  info_.title = "synthetic landscape, seed " + std::to_string(options.seed);
  const double side_samples = (options.size - 1) * (1 + 2 * kMargin);
  grid_size_ = std::clamp(static_cast<uint32_t>(side_samples) + 1, kCoarsest, kMaxGrid);
  grid_per_sample_ = (grid_size_ - 1) / side_samples;
  grid_cell_m_ = options.spacing_m / grid_per_sample_;
  grid_margin_ = kMargin * (options.size - 1) * grid_per_sample_;
  for (double wave = 3.2 * grid_cell_m_; wave >= 3 * options.spacing_m && detail_octaves_ < 8; wave *= 0.5)
    ++detail_octaves_;
  erode();
  fitHeights();
}

// Lengths and heights are in units of a 1024th of the side here, so that the numbers below do not depend on it.
void Landscape::erode() {
  const double unit_m = (options_.size - 1) * options_.spacing_m / 1024;
  const double side = (grid_size_ - 1) * grid_cell_m_ / unit_m;
  const double relief = reliefFor(1024 * unit_m) / unit_m;
  std::vector<uint32_t> sizes{grid_size_};
  while (sizes.back() > 2 * kCoarsest) sizes.push_back(sizes.back() / 2 + 1);
  Eroder eroder;
  ErosionGrid grid{.size = sizes.back(), .cell = side / (sizes.back() - 1), .height = {}, .uplift = {}};
  setYoungMountains(grid, relief, seed_);
  int rounds = 40;
  for (auto size = sizes.rbegin(); size != sizes.rend(); ++size) {
    const bool is_first = *size == sizes.back();
    if (*size != grid.size) grid = refined(grid, *size, seed_);
    setUplift(grid, kUpliftPerRelief * relief, seed_);
    roughen(grid, (is_first ? 0 : 0.003) * relief, seed_);
    for (int i = 0; i < rounds; ++i)
      eroder.run(grid, {.time = is_first ? 0.6 : 0.3,
                        .erodibility = 1,
                        .talus = kTalus,
                        .seed = seed_ + *size * 131 + static_cast<uint32_t>(i),
                        .diffusion = 0.15});
    rounds = std::max(6, rounds / 3);
  }
  eroder.fillValleys(grid, {.depth = 0.02 * relief, .min_area = 150, .seed = seed_});
  grid_ = std::move(grid.height);
}

// PathSpans the heights inside the margins to the range that the options state.
void Landscape::fitHeights() {
  const auto from = static_cast<uint32_t>(grid_margin_), to = grid_size_ - from;
  float lowest = grid_[size_t{from} * grid_size_ + from], highest = lowest;
  for (uint32_t y = from; y < to; ++y)
    for (uint32_t x = from; x < to; ++x) {
      lowest = std::min(lowest, grid_[size_t{y} * grid_size_ + x]);
      highest = std::max(highest, grid_[size_t{y} * grid_size_ + x]);
    }
  const double relief_m = reliefFor((options_.size - 1) * options_.spacing_m);
  const double stretch = highest > lowest ? relief_m / (double{highest} - lowest) : 1;
  for (float& h : grid_) h = static_cast<float>(kLowest_m + stretch * (double{h} - lowest));
}

Landscape::Surface Landscape::eroded(double grid_x, double grid_y) const {
  const auto x = std::clamp(static_cast<uint32_t>(grid_x), 1u, grid_size_ - 3);
  const auto y = std::clamp(static_cast<uint32_t>(grid_y), 1u, grid_size_ - 3);
  const Cubic u(grid_x - x), v(grid_y - y);
  double h = 0, along_x = 0, along_y = 0;
  for (uint32_t j = 0; j < 4; ++j) {
    const float* row = grid_.data() + size_t{y + j - 1} * grid_size_ + x - 1;
    const double value = u.value[0] * row[0] + u.value[1] * row[1] + u.value[2] * row[2] + u.value[3] * row[3];
    const double slope = u.slope[0] * row[0] + u.slope[1] * row[1] + u.slope[2] * row[2] + u.slope[3] * row[3];
    h += v.value[j] * value;
    along_x += v.value[j] * slope;
    along_y += v.slope[j] * value;
  }
  return {h, std::sqrt(along_x * along_x + along_y * along_y) / grid_cell_m_};
}

float Landscape::height(uint32_t x, uint32_t y) const {
  const double gx = grid_margin_ + x * grid_per_sample_, gy = grid_margin_ + y * grid_per_sample_;
  const Surface surface = eroded(gx, gy);
  double height_m = surface.height;
  const double roughness = 0.025 * std::min(1.0, surface.slope * 1.3);
  double wave = 3.2, amplitude_m = roughness * wave * grid_cell_m_;
  for (int i = 0; i < detail_octaves_; ++i) {
    const double crest = 0.5 - std::fabs(noise(gx / wave, gy / wave, seed_ + 101 + static_cast<uint32_t>(i)));
    height_m += amplitude_m * 1.6 * crest;
    wave *= 0.5;
    amplitude_m *= 0.55;
  }
  return static_cast<float>(height_m);
}

void Landscape::heights(uint32_t first, uint32_t count, std::span<float> out) const {
  CHECK_LE(uint64_t{first} + count, options_.size);
  CHECK_EQ(out.size(), size_t{count} * options_.size);
  for (uint32_t i = 0; i < count; ++i)
    for (uint32_t x = 0; x < options_.size; ++x) out[size_t{i} * options_.size + x] = height(x, first + i);
}

Status Landscape::readRows(uint32_t first, uint32_t count, std::span<float> out) {
  heights(first, count, out);
  return {};
}

}  // namespace foreland::terrain
