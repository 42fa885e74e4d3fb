#include "terrain/dem/mosaic_info.h"

#include <filesystem>
#include <utility>

#include "terrain/dem/formats/gdal_georeference.h"

namespace foreland::terrain {

namespace {

constexpr double kOnLattice = 0.01;  // samples

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

}  // namespace

std::string titleOf(const Mosaic& mosaic) {
  std::string title;
  for (const Tile& tile : mosaic.tiles) {
    if (title.size() > 200) return title + ", ...";
    title += (title.empty() ? "" : ", ") + std::filesystem::path(tile.raster->info().name).filename().string();
  }
  return title;
}

Result<ElevationInfo> describeMosaic(const Mosaic& mosaic, const RasterPlacement& placement,
                                     const std::optional<Datum>& datum, InputList list,
                                     std::vector<std::string> notes) {
  ElevationInfo info{.width = mosaic.width,
                     .height = mosaic.height,
                     .frame = placement.frame,
                     .title = titleOf(mosaic),
                     .crs_wkt = mosaic.map.crs_wkt,
                     .notes = std::move(notes)};
  info.notes.insert(info.notes.end(), mosaic.notes.begin(), mosaic.notes.end());
  info.notes.insert(info.notes.end(), placement.notes.begin(), placement.notes.end());
  if (datum || list == InputList::kAlways)
    for (const Tile& tile : mosaic.tiles) info.inputs.push_back(inputOf(tile, mosaic, placement));
  if (!datum) return info;
  auto vertical = datumOver(mosaic, placement, *datum, info.notes);
  if (!vertical.ok()) return vertical.error();
  info.vertical = std::move(*vertical);
  // A reference system must not say otherwise than the scene.
  if (mosaic.tiles.front().vertical != info.vertical.name) info.crs_wkt = withoutHeights(info.crs_wkt);
  return info;
}

}  // namespace foreland::terrain
