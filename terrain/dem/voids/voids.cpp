#include "terrain/dem/voids/voids.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/check.h"

namespace foreland::terrain {

namespace {

class GridInMemory final : public VoidGrid {
 public:
  GridInMemory(std::span<float> heights, uint32_t width, uint32_t height)
      : heights_(heights), width_(width), coarser_(coarserValues(width, height)) {}

  Status readRow(uint32_t y, std::span<float> out) override {
    std::ranges::copy(heights_.subspan(size_t{y} * width_, width_), out.begin());
    return {};
  }
  Status takeRow(uint32_t y, std::span<const float> row, const RunsOfRow&) override {
    std::ranges::copy(row, heights_.begin() + static_cast<std::ptrdiff_t>(size_t{y} * width_));
    return {};
  }
  Status put(uint64_t at, std::span<const float> values) override {
    std::ranges::copy(values, coarser_.begin() + static_cast<std::ptrdiff_t>(at));
    return {};
  }
  Status get(uint64_t at, std::span<float> values) override {
    std::ranges::copy(std::span(coarser_).subspan(at, values.size()), values.begin());
    return {};
  }

 private:
  std::span<float> heights_;
  uint32_t width_;
  std::vector<float> coarser_;
};

}  // namespace

VoidReport fillVoids(std::span<float> heights, uint32_t width, uint32_t height) {
  CHECK_EQ(heights.size(), size_t{width} * height);
  if (std::ranges::all_of(heights, [](float h) { return std::isfinite(h); })) return {.total = heights.size()};
  GridInMemory grid(heights, width, height);
  RowFiller filler(grid, width, height);
  CHECK_TRUE(filler.look().ok());
  if (!filler.report().all_void) CHECK_TRUE(filler.fill().ok());
  return filler.report();
}

}  // namespace foreland::terrain
