#include "terrain/dem/voids/low_rims.h"

#include <bit>
#include <cmath>
#include <limits>

#include "base/check.h"

namespace foreland::terrain {

namespace {

// Orders as the heights do.
uint32_t keyOf(float height) {
  const auto bits = std::bit_cast<uint32_t>(height);
  return bits >> 31 ? ~bits : bits | 1u << 31;
}
float heightOf(uint32_t key) { return std::bit_cast<float>(key >> 31 ? key & ~(1u << 31) : ~key); }

// The tenth percentile of a large region's rim: first the upper half of its key, then the lower.
struct Percentile {
  uint32_t upper = 0;
  uint64_t rank = 0;  // how many are lower
  std::vector<uint64_t> counts = std::vector<uint64_t>(1u << 16);

  // The half that the wanted one has; from here on it has `rank` lower ones among those with the same half.
  uint32_t find() {
    uint32_t half = 0;
    for (; rank >= counts[half]; ++half) rank -= counts[half];
    return half;
  }
  uint64_t total() const {
    uint64_t sum = 0;
    for (const uint64_t count : counts) sum += count;
    return sum;
  }
};

// Calls visit(region, height) for the finite heights beside the samples of large regions.
template <class Visit>
Status forEachOfRims(const VoidRegions& found, double least, uint32_t width, uint32_t height, const ReadRow& read,
                     const Visit& visit) {
  RowCache rows(width, read);
  for (const VoidRun& run : found.runs) {
    if (static_cast<double>(found.regions[run.region].samples) < least) continue;
    const auto add = [&](float h) {
      if (std::isfinite(h)) visit(run.region, h);
    };
    const auto addAll = [&](uint32_t y, uint32_t begin, uint32_t end) -> Status {
      const auto row = rows.at(y);
      if (!row) return row.error();
      for (uint32_t x = begin; x < end; ++x) add((*row)[x]);
      return {};
    };
    if (run.row > 0)
      if (Status s = addAll(run.row - 1, run.begin, run.end); !s.ok()) return s;
    // The run itself has no heights.
    if (Status s = addAll(run.row, run.begin - (run.begin > 0), run.end + (run.end < width)); !s.ok()) return s;
    if (run.row + 1 < height)
      if (Status s = addAll(run.row + 1, run.begin, run.end); !s.ok()) return s;
  }
  return {};
}

}  // namespace

Result<std::vector<float>> lowRims(const VoidRegions& found, double least, uint32_t width, uint32_t height,
                                   const ReadRow& read) {
  std::vector<float> flat(found.regions.size(), std::numeric_limits<float>::quiet_NaN());
  std::vector<uint32_t> index(found.regions.size());
  std::vector<Percentile> large;
  for (uint32_t i = 0; i < flat.size(); ++i) {
    if (static_cast<double>(found.regions[i].samples) < least) continue;
    index[i] = static_cast<uint32_t>(large.size());
    large.emplace_back();
  }
  if (large.empty()) return flat;
  const auto countUpper = [&](uint32_t region, float h) { ++large[index[region]].counts[keyOf(h) >> 16]; };
  if (Status s = forEachOfRims(found, least, width, height, read, countUpper); !s.ok()) return s.error();
  for (Percentile& of : large) {
    const uint64_t total = of.total();
    CHECK_TRUE(total > 0);  // not all is void
    of.rank = total / 10;
    of.upper = of.find();
    of.counts.assign(of.counts.size(), 0);
  }
  const auto countLower = [&](uint32_t region, float h) {
    Percentile& of = large[index[region]];
    if (keyOf(h) >> 16 == of.upper) ++of.counts[keyOf(h) & 0xffff];
  };
  if (Status s = forEachOfRims(found, least, width, height, read, countLower); !s.ok()) return s.error();
  for (uint32_t i = 0; i < flat.size(); ++i) {
    if (static_cast<double>(found.regions[i].samples) < least) continue;
    Percentile& of = large[index[i]];
    flat[i] = heightOf(of.upper << 16 | of.find());
  }
  return flat;
}

}  // namespace foreland::terrain
