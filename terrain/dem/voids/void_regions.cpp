#include "terrain/dem/voids/void_regions.h"

#include <algorithm>
#include <utility>

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

void RegionFinder::add(std::span<const float> row) {
  const uint32_t y = rows_++;
  if (too_many_) return;
  const size_t here = found_.runs.size();
  forEachVoidRun(row, [&](uint32_t begin, uint32_t end) {
    parent_.push_back(static_cast<uint32_t>(found_.runs.size()));
    found_.runs.push_back({.row = y, .begin = begin, .end = end});
  });
  if (found_.runs.size() > max_runs_) {
    too_many_ = true;
    found_ = {};
    parent_ = {};
    return;
  }
  uniteRows(parent_, found_.runs, before_, here);
  before_ = here;
}

std::optional<VoidRegions> RegionFinder::finish() {
  if (too_many_) return std::nullopt;
  nameRegions(parent_, found_);
  parent_ = {};
  return std::move(found_);
}

std::optional<VoidRegions> findVoidRegions(std::span<const float> heights, uint32_t width, uint32_t height,
                                           size_t max_runs) {
  RegionFinder finder(max_runs);
  for (uint32_t y = 0; y < height; ++y) finder.add(heights.subspan(size_t{y} * width, width));
  return finder.finish();
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

}  // namespace foreland::terrain
