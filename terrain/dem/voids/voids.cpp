#include "terrain/dem/voids/voids.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <vector>

#include "base/check.h"
#include "terrain/dem/voids/void_regions.h"

namespace foreland::terrain {

namespace {

constexpr float kHole = std::numeric_limits<float>::quiet_NaN();
constexpr size_t kMaxRuns = size_t{1} << 24;
constexpr double kFlatShare = 0.02;  // of all samples: regions at least this large are filled flat,
constexpr int kFlatLevels = 5;       // wherever a block of 2^5 samples a side lies wholly inside the region
constexpr int kRelaxations = 8;

struct Level {
  uint32_t width = 0, height = 0;
  std::span<float> values;
  float& at(uint32_t x, uint32_t y) { return values[size_t{y} * width + x]; }
  float at(uint32_t x, uint32_t y) const { return values[size_t{y} * width + x]; }
};

// One bit per sample of a level: set where it has a hole. Kept apart from the values, which stop being NaN when first
// filled.
using HoleBits = std::vector<uint64_t>;

// Mean of the data among the four samples below each; a hole if there is none.
void pull(const Level& fine, Level& coarse) {
  for (uint32_t y = 0; y < coarse.height; ++y) {
    for (uint32_t x = 0; x < coarse.width; ++x) {
      float sum = 0;
      int count = 0;
      for (uint32_t v = 2 * y; v < std::min(2 * y + 2, fine.height); ++v)
        for (uint32_t u = 2 * x; u < std::min(2 * x + 2, fine.width); ++u)
          if (const float h = fine.at(u, v); std::isfinite(h)) {
            sum += h;
            ++count;
          }
      coarse.at(x, y) = count == 0 ? kHole : sum / static_cast<float>(count);
    }
  }
}

// The coarse level at the centre of a fine sample, bilinear.
float interpolate(const Level& coarse, uint32_t x, uint32_t y) {
  const uint32_t x1 = x / 2, y1 = y / 2;
  const uint32_t x2 = x & 1 ? std::min(x1 + 1, coarse.width - 1) : (x1 == 0 ? 0 : x1 - 1);
  const uint32_t y2 = y & 1 ? std::min(y1 + 1, coarse.height - 1) : (y1 == 0 ? 0 : y1 - 1);
  return 0.75f * (0.75f * coarse.at(x1, y1) + 0.25f * coarse.at(x2, y1)) +
         0.25f * (0.75f * coarse.at(x1, y2) + 0.25f * coarse.at(x2, y2));
}

// One Gauss-Seidel sweep over the holes: each becomes the mean of its neighbours.
void relax(Level& level, const HoleBits& holes) {
  for (size_t word = 0; word < holes.size(); ++word) {
    for (uint64_t bits = holes[word]; bits != 0; bits &= bits - 1) {
      const size_t at = word * 64 + static_cast<size_t>(std::countr_zero(bits));
      const auto x = static_cast<uint32_t>(at % level.width), y = static_cast<uint32_t>(at / level.width);
      const float* here = level.values.data() + at;
      const float w = x > 0 ? here[-1] : *here, e = x + 1 < level.width ? here[1] : *here;
      const float s = y > 0 ? *(here - level.width) : *here, n = y + 1 < level.height ? here[level.width] : *here;
      level.values[at] = 0.25f * ((w + e) + (s + n));
    }
  }
}

// Fills the holes of a level from the coarser one, then relaxes them.
void push(const Level& coarse, Level& fine) {
  HoleBits holes(fine.values.size() / 64 + 1);
  for (uint32_t y = 0; y < fine.height; ++y) {
    for (uint32_t x = 0; x < fine.width; ++x) {
      const size_t at = size_t{y} * fine.width + x;
      if (std::isfinite(fine.values[at])) continue;
      fine.values[at] = interpolate(coarse, x, y);
      holes[at / 64] |= uint64_t{1} << (at % 64);
    }
  }
  for (int sweep = 0; sweep < kRelaxations; ++sweep) relax(fine, holes);
}

// Of each region: the height at which it is filled flat, or NaN for a membrane.
std::vector<float> flatHeights(std::span<const float> heights, uint32_t width, uint32_t height,
                               const VoidRegions& found) {
  std::vector<float> flat(found.regions.size(), kHole);
  const double least = std::max(kFlatShare * static_cast<double>(heights.size()), 1024.0);
  for (uint32_t i = 0; i < flat.size(); ++i)
    if (static_cast<double>(found.regions[i].samples) >= least) flat[i] = lowRim(heights, width, height, found, i);
  return flat;
}

// Fills the blocks of this level that have no data at all. A block is connected, so all of its samples are of one
// region.
void pinFlat(Level& level, int log2, const VoidRegions& found, const std::vector<float>& flat) {
  for (uint32_t y = 0; y < level.height; ++y)
    for (uint32_t x = 0; x < level.width; ++x)
      if (!std::isfinite(level.at(x, y))) level.at(x, y) = flat[found.regionAt(x << log2, y << log2)];
}

int flatLevel(uint32_t width, uint32_t height) {
  int level = 1;
  while (level < kFlatLevels && (std::min(width, height) >> (level + 1)) >= 16) ++level;
  return level;
}

void fill(std::span<float> heights, uint32_t width, uint32_t height, const VoidRegions* found,
          const std::vector<float>& flat) {
  std::vector<std::vector<float>> storage;
  std::vector<Level> levels{{width, height, heights}};
  const int pin_at = flatLevel(width, height);
  while (levels.back().width > 1 || levels.back().height > 1) {
    const Level fine = levels.back();
    Level coarse{(fine.width + 1) / 2, (fine.height + 1) / 2, {}};
    storage.emplace_back(size_t{coarse.width} * coarse.height);
    coarse.values = storage.back();
    pull(fine, coarse);
    levels.push_back(coarse);
    if (found != nullptr && static_cast<int>(levels.size()) - 1 == pin_at) pinFlat(levels.back(), pin_at, *found, flat);
  }
  for (size_t i = levels.size() - 1; i > 0; --i) push(levels[i], levels[i - 1]);
}

std::string describe(const VoidReport& report) {
  const double percent = 100.0 * static_cast<double>(report.samples) / static_cast<double>(report.total);
  std::array<char, 320> text{};
  std::snprintf(text.data(), text.size(), "%llu void samples (%.1f %%) in %llu region%s were filled%s",
                static_cast<unsigned long long>(report.samples), percent,
                static_cast<unsigned long long>(report.regions), report.regions == 1 ? "" : "s",
                report.flat_regions == 0 ? " smoothly from their rims"
                                         : " smoothly from their rims, large ones flat at a low height of theirs");
  return text.data();
}

}  // namespace

VoidReport fillVoids(std::span<float> heights, uint32_t width, uint32_t height) {
  CHECK_EQ(heights.size(), size_t{width} * height);
  VoidReport report{.total = heights.size()};
  for (const float h : heights) report.samples += std::isfinite(h) ? 0 : 1;
  report.all_void = report.samples == report.total;
  if (report.samples == 0 || report.all_void) return report;

  const std::optional<VoidRegions> found = findVoidRegions(heights, width, height, kMaxRuns);
  std::vector<float> flat;
  if (found) {
    flat = flatHeights(heights, width, height, *found);
    report.regions = found->regions.size();
    for (const VoidRegion& region : found->regions)
      report.largest_region = std::max(report.largest_region, region.samples);
    report.flat_regions =
        static_cast<uint64_t>(std::count_if(flat.begin(), flat.end(), [](float h) { return std::isfinite(h); }));
  }
  fill(heights, width, height, found ? &*found : nullptr, flat);
  report.note = describe(report);
  return report;
}

}  // namespace foreland::terrain
