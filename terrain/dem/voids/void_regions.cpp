#include "terrain/dem/voids/void_regions.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"

namespace foreland::terrain {

namespace {

uint32_t find(std::vector<uint32_t>& parent, uint32_t run) {
  while (parent[run] != run) run = parent[run] = parent[parent[run]];
  return run;
}

void unite(std::vector<uint32_t>& parent, uint32_t a, uint32_t b) {
  a = find(parent, a);
  b = find(parent, b);
  parent[std::max(a, b)] = std::min(a, b);  // the first run of a region stays its root
}

// Unites the runs of one row with those of the row before that they touch.
void uniteRows(std::vector<uint32_t>& parent, const std::vector<VoidRun>& runs, size_t before, size_t here) {
  size_t above = before, below = here;
  while (above < here && below < runs.size()) {
    if (runs[above].begin < runs[below].end && runs[below].begin < runs[above].end)
      unite(parent, static_cast<uint32_t>(above), static_cast<uint32_t>(below));
    if (runs[above].end < runs[below].end)
      ++above;
    else
      ++below;
  }
}

void nameRegions(std::vector<uint32_t>& parent, VoidRegions& found) {
  for (uint32_t i = 0; i < found.runs.size(); ++i) {
    const uint32_t root = find(parent, i);
    if (root == i) {
      found.runs[i].region = static_cast<uint32_t>(found.regions.size());
      found.regions.emplace_back();
    } else {
      found.runs[i].region = found.runs[root].region;
    }
    found.regions[found.runs[i].region].samples += found.runs[i].end - found.runs[i].begin;
  }
}

}  // namespace

std::optional<VoidRegions> findVoidRegions(std::span<const float> heights, uint32_t width, uint32_t height,
                                           size_t max_runs) {
  VoidRegions found;
  std::vector<uint32_t> parent;
  size_t before = 0;
  for (uint32_t y = 0; y < height; ++y) {
    const float* row = heights.data() + size_t{y} * width;
    const size_t here = found.runs.size();
    for (uint32_t x = 0; x < width;) {
      if (std::isfinite(row[x])) {
        ++x;
        continue;
      }
      uint32_t end = x;
      while (end < width && !std::isfinite(row[end])) ++end;
      parent.push_back(static_cast<uint32_t>(found.runs.size()));
      found.runs.push_back({.row = y, .begin = x, .end = end});
      x = end;
    }
    if (found.runs.size() > max_runs) return std::nullopt;
    uniteRows(parent, found.runs, before, here);
    before = here;
  }
  nameRegions(parent, found);
  return found;
}

uint32_t VoidRegions::regionAt(uint32_t x, uint32_t y) const {
  auto after = std::upper_bound(runs.begin(), runs.end(), std::pair{y, x},
                                [](const std::pair<uint32_t, uint32_t>& at, const VoidRun& run) {
                                  return at < std::pair{run.row, run.begin};
                                });
  CHECK_TRUE(after != runs.begin());
  const VoidRun& run = *std::prev(after);
  CHECK_TRUE(run.row == y && x < run.end);
  return run.region;
}

float lowRim(std::span<const float> heights, uint32_t width, uint32_t height, const VoidRegions& found,
             uint32_t region) {
  std::vector<float> rim;
  const auto add = [&](uint32_t x, uint32_t y) {
    const float h = heights[size_t{y} * width + x];
    if (std::isfinite(h)) rim.push_back(h);
  };
  for (const VoidRun& run : found.runs) {
    if (run.region != region) continue;
    if (run.begin > 0) add(run.begin - 1, run.row);
    if (run.end < width) add(run.end, run.row);
    for (uint32_t x = run.begin; x < run.end; ++x) {
      if (run.row > 0) add(x, run.row - 1);
      if (run.row + 1 < height) add(x, run.row + 1);
    }
  }
  if (rim.empty()) return 0;
  const auto tenth = rim.begin() + static_cast<std::ptrdiff_t>(rim.size() / 10);
  std::nth_element(rim.begin(), tenth, rim.end());
  return *tenth;
}

}  // namespace foreland::terrain
