#include "terrain/dem/open.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <system_error>

#include "base/check.h"
#include "terrain/dem/datum.h"
#include "terrain/dem/formats/exr_raster.h"
#include "terrain/dem/formats/gdal_georeference.h"
#include "terrain/dem/formats/gdal_raster.h"
#include "terrain/dem/mosaic/mosaic.h"
#include "terrain/dem/mosaic/overlap.h"
#include "terrain/dem/mosaic/placement.h"

namespace foreland::terrain {

namespace {

constexpr uint32_t kWindowRows = 64;
constexpr double kOnLattice = 0.01;  // samples

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

Status checkFile(const std::filesystem::path& path) {
  std::error_code failed;
  const auto status = std::filesystem::status(path, failed);
  const std::string name = path.string();
  if (!std::filesystem::exists(status)) return Error{ErrorCode::kNotFound, name + ": no such file; check the path"};
  if (std::filesystem::is_directory(status))
    return Error{ErrorCode::kInvalidArgument, name + ": a directory; name the elevation files in it"};
  if (!std::filesystem::is_regular_file(status)) return Error{ErrorCode::kUnsupported, name + ": not a regular file"};
  const auto size = std::filesystem::file_size(path, failed);
  if (!failed && size == 0) return Error{ErrorCode::kMalformed, name + ": an empty file (0 bytes); get it anew"};
  std::FILE* readable = std::fopen(path.c_str(), "rb");
  if (readable == nullptr)
    return Error{ErrorCode::kIo, name + ": cannot be read: " + std::generic_category().message(errno)};
  std::fclose(readable);
  return {};
}

Result<std::vector<std::unique_ptr<Raster>>> openFile(const std::filesystem::path& path, const OpenOptions& options) {
  if (Status s = checkFile(path); !s.ok()) return s.error();
  if (!isExrFile(path)) return openGdalRasters(path, options);
  Result<std::unique_ptr<Raster>> exr = openExrRaster(path, options);
  if (!exr.ok()) return exr.error();
  std::vector<std::unique_ptr<Raster>> one;
  one.push_back(std::move(exr).value());
  return one;
}

Extent extentOf(const Raster& raster) {
  const RasterInfo& info = raster.info();
  return {info.name, info.width, info.height, info.survey.lowest, info.survey.highest};
}

// A raster with its rows, columns or both in the opposite order.
class Turned final : public Raster {
 public:
  Turned(std::unique_ptr<Raster> inner, bool rows, bool columns)
      : inner_(std::move(inner)), rows_(rows), columns_(columns) {}
  const RasterInfo& info() const override { return inner_->info(); }
  Status readRows(uint32_t first, uint32_t count, std::span<float> out) override {
    const uint32_t width = info().width;
    if (Status s = inner_->readRows(rows_ ? info().height - first - count : first, count, out); !s.ok()) return s;
    if (rows_)
      for (uint32_t i = 0; i < count / 2; ++i)
        std::swap_ranges(out.begin() + size_t{i} * width, out.begin() + size_t{i + 1} * width,
                         out.begin() + size_t{count - 1 - i} * width);
    if (columns_)
      for (uint32_t i = 0; i < count; ++i)
        std::reverse(out.begin() + size_t{i} * width, out.begin() + size_t{i + 1} * width);
    return {};
  }

 private:
  std::unique_ptr<Raster> inner_;
  bool rows_, columns_;
};

// Rows of some files go south and those of others north: all are made to go south, and columns east.
void orientAlike(std::vector<Tile>& tiles) {
  const auto goes = [](const Tile& tile) { return std::pair(tile.map.transform[1] > 0, tile.map.transform[5] < 0); };
  const auto isStraight = [](const Tile& tile) { return tile.map.transform[2] == 0 && tile.map.transform[4] == 0; };
  if (tiles.empty() || !std::ranges::all_of(tiles, isStraight) ||
      std::ranges::all_of(tiles, [&](const Tile& tile) { return goes(tile) == goes(tiles.front()); }))
    return;
  for (Tile& tile : tiles) {
    auto& t = tile.map.transform;
    const bool columns = t[1]<0, rows = t[5]> 0;
    if (!columns && !rows) continue;
    if (columns) t[0] += (tile.raster->info().width - 1.0) * t[1], t[1] = -t[1];
    if (rows) t[3] += (tile.raster->info().height - 1.0) * t[5], t[5] = -t[5];
    tile.raster = std::make_unique<Turned>(std::move(tile.raster), rows, columns);
  }
}

// Every raster of every input with its map resolved. Adds what had to be assumed about each file to `notes`.
Result<std::vector<Tile>> openTiles(const std::vector<std::filesystem::path>& inputs, const OpenOptions& options,
                                    std::vector<std::string>& notes) {
  std::vector<Tile> tiles;
  for (const std::filesystem::path& input : inputs) {
    Result<std::vector<std::unique_ptr<Raster>>> rasters = openFile(input, options);
    if (!rasters.ok()) return rasters.error();
    for (std::unique_ptr<Raster>& raster : *rasters) {
      std::vector<std::string> file_notes = raster->info().notes;
      Result<Georeference> map = resolveMap(raster->info().georeference, extentOf(*raster), options, file_notes);
      if (!map.ok()) return map.error();
      const std::string file = std::filesystem::path(raster->info().name).filename().string();
      for (const std::string& note : file_notes) notes.push_back(file + ": " + note);
      tiles.push_back({.raster = std::move(raster), .map = std::move(map).value(), .input = input.string()});
    }
  }
  orientAlike(tiles);
  return tiles;
}

std::string titleOf(const Mosaic& mosaic) {
  std::string title;
  for (const Tile& tile : mosaic.tiles) {
    if (title.size() > 200) return title + ", ...";
    title += (title.empty() ? "" : ", ") + std::filesystem::path(tile.raster->info().name).filename().string();
  }
  return title;
}

ElevationInput inputOf(const Tile& tile, const Mosaic& mosaic, const RasterPlacement& placement) {
  const RasterInfo& raster = tile.raster->info();
  const auto from = [](bool is_reversed, uint32_t whole, uint32_t first, uint32_t count) {
    return is_reversed ? whole - first - count : first;
  };
  return {
      .name = std::filesystem::path(raster.name).filename().string(),
      .window = {from(placement.is_column_reversed, mosaic.width, tile.column, raster.width),
                 from(placement.is_row_reversed, mosaic.height, tile.row, raster.height), raster.width, raster.height},
      .vertical = tile.vertical,
      .may_have_voids = raster.survey.voids > 0 || raster.survey.samples < uint64_t{raster.width} * raster.height,
      .is_on_lattice = tile.off_lattice <= kOnLattice};
}

Status describeDatum(const Mosaic& mosaic, const RasterPlacement& placement, const Datum& datum, ElevationInfo& info) {
  auto vertical = datumOver(mosaic, placement, datum, info.notes);
  if (!vertical.ok()) return vertical.error();
  info.vertical = std::move(*vertical);
  for (const Tile& tile : mosaic.tiles) info.inputs.push_back(inputOf(tile, mosaic, placement));
  // A reference system must not say otherwise than the scene.
  if (mosaic.tiles.front().vertical != info.vertical.name) info.crs_wkt = withoutHeights(info.crs_wkt);
  return {};
}

}  // namespace

Result<std::unique_ptr<ElevationSource>> openElevation(const std::vector<std::filesystem::path>& inputs,
                                                       const OpenOptions& options) {
  if (inputs.empty()) return Error{ErrorCode::kInvalidArgument, "no elevation file was named"};
  ElevationInfo info;
  Result<std::vector<Tile>> tiles = openTiles(inputs, options, info.notes);
  if (!tiles.ok()) return tiles.error();
  const auto datum = alignHeights(*tiles, options, info.notes);
  if (!datum.ok()) return datum.error();
  Result<Mosaic> mosaic = makeMosaic(std::move(tiles).value());
  if (!mosaic.ok()) return mosaic.error();
  const Result<RasterPlacement> placement =
      placeRaster(mosaic->map, {titleOf(*mosaic), mosaic->width, mosaic->height, 0, 0}, options);
  if (!placement.ok()) return placement.error();
  info.width = mosaic->width;
  info.height = mosaic->height;
  info.frame = placement->frame;
  info.title = titleOf(*mosaic);
  info.crs_wkt = mosaic->map.crs_wkt;
  info.notes.insert(info.notes.end(), mosaic->notes.begin(), mosaic->notes.end());
  info.notes.insert(info.notes.end(), placement->notes.begin(), placement->notes.end());
  if (datum->has_value())
    if (Status s = describeDatum(*mosaic, *placement, **datum, info); !s.ok()) return s.error();
  return std::unique_ptr<ElevationSource>(
      std::make_unique<RasterSource>(std::move(mosaic).value(), *placement, std::move(info)));
}

}  // namespace foreland::terrain
