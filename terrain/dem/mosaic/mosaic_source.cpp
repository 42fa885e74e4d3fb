#include "terrain/dem/mosaic/mosaic_source.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "base/check.h"
#include "terrain/dem/mosaic/overlap.h"

namespace foreland::terrain {

namespace {

constexpr uint32_t kWindowRows = 64;

// Rows are fetched from the files in windows, top to bottom within each: archives and text formats are slow to read
// backwards.
class RasterSource final : public ElevationSource {
 public:
  RasterSource(Mosaic mosaic, const RasterPlacement& placement, ElevationInfo info)
      : mosaic_(std::move(mosaic)), placement_(placement), info_(std::move(info)), overlaps_(mosaic_.tiles.size()) {}

  const ElevationInfo& info() const override { return info_; }

  Status readRows(uint32_t first, uint32_t count, std::span<float> out) override {
    CHECK_LE(uint64_t{first} + count, info_.height);
    CHECK_EQ(out.size(), size_t{count} * info_.width);
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t row = placement_.is_row_reversed ? info_.height - 1 - (first + i) : first + i;
      if (Status s = load(row); !s.ok()) return s;
      const float* from = window_.data() + size_t{row - window_first_} * info_.width;
      float* to = out.data() + size_t{i} * info_.width;
      if (placement_.is_column_reversed)
        std::reverse_copy(from, from + info_.width, to);
      else
        std::copy(from, from + info_.width, to);
    }
    return {};
  }

  std::vector<std::string> warnings() const override {
    std::vector<std::string> all;
    for (size_t i = 0; i < overlaps_.size(); ++i)
      if (const auto doubt = overlaps_[i].doubt())
        all.push_back(firstUnder(i) + " and " + mosaic_.tiles[i].raster->info().name +
                      " do not agree where they overlap: " + *doubt);
    return all;
  }

 private:
  // The name of the first tile that lies under a tile.
  std::string firstUnder(size_t tile) const {
    const auto overlap = [](uint32_t a, uint32_t a_count, uint32_t b, uint32_t b_count) {
      return uint64_t{a} < uint64_t{b} + b_count && uint64_t{b} < uint64_t{a} + a_count;
    };
    const Tile& t = mosaic_.tiles[tile];
    for (const Tile& other : mosaic_.tiles) {
      const RasterInfo &o = other.raster->info(), &r = t.raster->info();
      if (overlap(other.column, o.width, t.column, r.width) && overlap(other.row, o.height, t.row, r.height))
        return o.name;
    }
    return "the first input";
  }

  // Loads the window that contains file row `row`.
  Status load(uint32_t row) {
    if (row >= window_first_ && row < window_first_ + window_count_) return {};
    window_first_ = row / kWindowRows * kWindowRows;
    window_count_ = 0;
    const uint32_t count = std::min(kWindowRows, info_.height - window_first_);
    window_.assign(size_t{count} * info_.width, kVoid);
    for (size_t i = 0; i < mosaic_.tiles.size(); ++i)
      if (Status s = copyTile(mosaic_.tiles[i], count, overlaps_[i]); !s.ok()) return s;
    window_count_ = count;
    return {};
  }

  // Copies the part of a tile that lies in the window, but only where no earlier tile has data.
  Status copyTile(Tile& tile, uint32_t window_count, Overlap& overlap) {
    const uint32_t begin = std::max(window_first_, tile.row);
    const uint32_t end = std::min(window_first_ + window_count, tile.row + tile.raster->info().height);
    if (begin >= end) return {};
    const uint32_t width = tile.raster->info().width;
    tile_rows_.resize(size_t{end - begin} * width);
    if (Status s = tile.raster->readRows(begin - tile.row, end - begin, tile_rows_); !s.ok()) return s;
    for (uint32_t row = begin; row < end; ++row) {
      const float* from = tile_rows_.data() + size_t{row - begin} * width;
      float* to = window_.data() + size_t{row - window_first_} * info_.width + tile.column;
      for (uint32_t x = 0; x < width; ++x)
        if (std::isnan(to[x]))
          to[x] = from[x];
        else if (!std::isnan(from[x]))
          overlap.add(to[x], from[x]);
    }
    return {};
  }

  Mosaic mosaic_;
  RasterPlacement placement_;
  ElevationInfo info_;
  std::vector<Overlap> overlaps_;  // of each tile with those before it
  std::vector<float> window_, tile_rows_;
  uint32_t window_first_ = 0, window_count_ = 0;
};

}  // namespace

std::unique_ptr<ElevationSource> mosaicSource(Mosaic mosaic, const RasterPlacement& placement, ElevationInfo info) {
  return std::make_unique<RasterSource>(std::move(mosaic), placement, std::move(info));
}

}  // namespace foreland::terrain
