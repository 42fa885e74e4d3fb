#include "terrain/dem/tiles.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>
#include <utility>

#include "terrain/dem/formats/exr_raster.h"
#include "terrain/dem/formats/gdal_raster.h"
#include "terrain/dem/mosaic/placement.h"

namespace foreland::terrain {

namespace {

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

}  // namespace

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

}  // namespace foreland::terrain
