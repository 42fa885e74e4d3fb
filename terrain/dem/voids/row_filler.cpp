#include "terrain/dem/voids/row_filler.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "base/check.h"
#include "terrain/dem/voids/low_rims.h"

namespace foreland::terrain {

namespace {

constexpr float kHole = std::numeric_limits<float>::quiet_NaN();
constexpr double kFlatShare = 0.02;  // of all samples: regions at least this large are filled flat,
constexpr size_t kFlatLevels = 5;    // wherever a block of 2^5 samples a side lies wholly inside the region

size_t flatLevel(uint32_t width, uint32_t height) {
  size_t level = 1;
  while (level < kFlatLevels && (std::min(width, height) >> (level + 1)) >= 16) ++level;
  return level;
}

// Mean of the data among the four samples below each; a hole if there is none. `north` may be empty.
void pullRow(std::span<const float> south, std::span<const float> north, std::span<float> coarse) {
  for (uint32_t x = 0; x < coarse.size(); ++x) {
    float sum = 0;
    int count = 0;
    for (const std::span<const float> row : {south, north})
      for (size_t u = 2 * size_t{x}; u < std::min(2 * size_t{x} + 2, row.size()); ++u)
        if (std::isfinite(row[u])) {
          sum += row[u];
          ++count;
        }
    coarse[x] = count == 0 ? kHole : sum / static_cast<float>(count);
  }
}

// Fills the blocks of a row of a level that have no data at all. A block is connected, so all of its samples are of one
// region.
void pinFlat(std::span<float> row, uint32_t y, size_t log2, const VoidRegions& found, const std::vector<float>& flat) {
  for (uint32_t x = 0; x < row.size(); ++x)
    if (!std::isfinite(row[x])) row[x] = flat[found.regionAt(x << log2, y << log2)];
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

uint64_t coarserValues(uint32_t width, uint32_t height) {
  uint64_t values = 0;
  while (width > 1 || height > 1) {
    width = (width + 1) / 2, height = (height + 1) / 2;
    values += uint64_t{width} * height;
  }
  return values;
}

RowFiller::RowFiller(VoidGrid& grid, uint32_t width, uint32_t height, size_t max_runs)
    : grid_(grid),
      pin_at_(flatLevel(width, height)),
      rows_(height),
      finder_(max_runs),
      report_{.total = uint64_t{width} * height} {
  levels_.push_back({.size = {width, height}});
  for (uint64_t at = 0; levels_.back().size.width > 1 || levels_.back().size.height > 1;) {
    const RowLevel fine = levels_.back().size;
    levels_.push_back({.size = {(fine.width + 1) / 2, (fine.height + 1) / 2}, .at = at});
    at += uint64_t{levels_.back().size.width} * levels_.back().size.height;
  }
  for (Level& level : levels_) level.has_void.resize(level.size.height);
  pin_at_ = std::min(pin_at_, levels_.size() - 1);
}

double RowFiller::leastFlat() const { return std::max(kFlatShare * static_cast<double>(report_.total), 1024.0); }

Status RowFiller::look() {
  std::vector<float> row(levels_[0].size.width);
  for (uint32_t y = 0; y < levels_[0].size.height; ++y) {
    if (Status s = grid_.readRow(y, row); !s.ok()) return s;
    finder_.add(row);
    forEachVoidRun(row, [&](uint32_t begin, uint32_t end) {
      ++rows_[y].runs;
      rows_[y].samples += end - begin;
    });
    report_.samples += rows_[y].samples;
    if (Status s = keep(0, y, row, pin_at_); !s.ok()) return s;
  }
  report_.all_void = report_.samples == report_.total;
  if (report_.samples == 0 || report_.all_void) return {};
  if ((found_ = finder_.finish())) {
    report_.regions = found_->regions.size();
    for (const VoidRegion& region : found_->regions) {
      report_.largest_region = std::max(report_.largest_region, region.samples);
      if (static_cast<double>(region.samples) >= leastFlat()) ++report_.flat_regions;
    }
  }
  report_.note = describe(report_);
  return {};
}

// Keeps a row of a level, and the rows of coarser ones that follow from it, as far as `coarsest`. Rows of a level come
// from south to north.
Status RowFiller::keep(size_t index, uint32_t y, std::span<const float> row, size_t coarsest) {
  Level& level = levels_[index];
  level.has_void[y] = !std::all_of(row.begin(), row.end(), [](float h) { return std::isfinite(h); });
  if (index > 0)
    if (Status s = grid_.put(level.at + uint64_t{y} * level.size.width, row); !s.ok()) return s;
  if (index == coarsest) return {};
  const bool is_even = (y & 1) == 0;
  if (is_even && y + 1 < level.size.height) {
    level.even.assign(row.begin(), row.end());
    return {};
  }
  Level& coarse = levels_[index + 1];
  coarse.row.resize(coarse.size.width);
  pullRow(is_even ? row : level.even, is_even ? std::span<const float>() : row, coarse.row);
  return keep(index + 1, y / 2, coarse.row, coarsest);
}

Status RowFiller::get(size_t index, uint32_t y, std::span<float> out) {
  if (index == 0) return grid_.readRow(y, out);
  const Level& level = levels_[index];
  return grid_.get(level.at + uint64_t{y} * level.size.width, out);
}

// Pins the level that flat regions are flat at, and makes coarser ones.
Status RowFiller::makeCoarse() {
  std::vector<float> flat;
  if (report_.flat_regions > 0) {
    auto rims = lowRims(*found_, leastFlat(), levels_[0].size.width, levels_[0].size.height,
                        [&](uint32_t y, std::span<float> out) { return grid_.readRow(y, out); });
    if (!rims) return rims.error();
    flat = std::move(rims).value();
  }
  const RowLevel size = levels_[pin_at_].size;
  std::vector<float> row(size.width);
  for (uint32_t y = 0; y < size.height; ++y) {
    if (Status s = get(pin_at_, y, row); !s.ok()) return s;
    if (!flat.empty()) pinFlat(row, y, pin_at_, *found_, flat);
    if (Status s = keep(pin_at_, y, row, levels_.size() - 1); !s.ok()) return s;
  }
  found_.reset();
  return {};
}

Status RowFiller::push(size_t index) {
  const Level &fine = levels_[index], &coarse = levels_[index + 1];
  const PushInput input{fine.size, coarse.size, [&](uint32_t y, std::span<float> out) { return get(index, y, out); },
                        [&](uint32_t y, std::span<float> out) { return get(index + 1, y, out); }, fine.has_void};
  return pushRows(input, [&](uint32_t y, std::span<const float> row, const RunsOfRow& runs) {
    return index == 0 ? grid_.takeRow(y, row, runs) : grid_.put(fine.at + uint64_t{y} * fine.size.width, row);
  });
}

Status RowFiller::fill() {
  CHECK_TRUE(report_.samples > 0 && !report_.all_void);
  if (Status s = makeCoarse(); !s.ok()) return s;
  for (size_t index = levels_.size() - 1; index > 0; --index)
    if (Status s = push(index - 1); !s.ok()) return s;
  return {};
}

}  // namespace foreland::terrain
