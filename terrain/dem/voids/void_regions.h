// Connected regions of voids in a height grid, as runs of samples in rows. Memory is in proportion to the number of
// runs.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace foreland::terrain {

struct VoidRun {
  uint32_t row = 0;
  uint32_t begin = 0;  // first void sample
  uint32_t end = 0;    // one past the last
  uint32_t region = 0;
};

struct VoidRegion {
  uint64_t samples = 0;
};

struct VoidRegions {
  std::vector<VoidRun> runs;        // by row, then by column
  std::vector<VoidRegion> regions;  // in the order of their first run
  // The region of a void sample; the sample must be void.
  uint32_t regionAt(uint32_t x, uint32_t y) const;
};

// Empty if there are more runs than `max_runs`.
std::optional<VoidRegions> findVoidRegions(std::span<const float> heights, uint32_t width, uint32_t height,
                                           size_t max_runs);

// Tenth percentile of the finite heights beside a region's samples, 0 if there are none. Cost: linear in the runs of
// all regions.
float lowRim(std::span<const float> heights, uint32_t width, uint32_t height, const VoidRegions& found,
             uint32_t region);

}  // namespace foreland::terrain
