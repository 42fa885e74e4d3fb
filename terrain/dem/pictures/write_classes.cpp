#include "terrain/dem/pictures/write_classes.h"

#include <fmt/format.h>
#include <gdal.h>

#include "base/check.h"
#include "terrain/dem/formats/gdal_files.h"
#include "terrain/dem/formats/gdal_messages.h"
#include "terrain/dem/formats/gdal_raster.h"
#include "terrain/dem/formats/pending_file.h"
#include "terrain/dem/pictures/lattice_map.h"
#include "terrain/dem/pictures/picture_file.h"

namespace foreland::terrain {

namespace {

Error unwritten(const std::filesystem::path& path, const GdalMessages& messages) {
  return {ErrorCode::kIo, fmt::format("{}: cannot be written; nothing of it was kept{}", path.string(),
                                      messages.hasErrors() ? " (GDAL says: " + messages.errors() + ")" : "")};
}

bool place(GDALDatasetH dataset, const LatticeMap& map, const ClassGrid& grid) {
  const glm::dvec2 north_west(grid.first.x, grid.first.y + (grid.rows - 1) * grid.step.y);
  auto transform = map.transform(north_west + glm::dvec2(-0.5, 0.5) * grid.step, grid.step);
  return GDALSetGeoTransform(dataset, transform.data()) == CE_None &&
         (map.referenceSystem() == nullptr || GDALSetSpatialRef(dataset, map.referenceSystem()) == CE_None);
}

// Files have rows from the north.
bool writeRows(GDALRasterBandH band, const ClassGrid& grid, std::span<const uint8_t> classes) {
  const int width = static_cast<int>(grid.columns);
  for (uint32_t row = 0; row < grid.rows; ++row) {
    const auto line = classes.subspan(size_t{grid.rows - 1 - row} * grid.columns, grid.columns);
    if (GDALRasterIO(band, GF_Write, 0, static_cast<int>(row), width, 1, const_cast<uint8_t*>(line.data()), width, 1,
                     GDT_Byte, 0, 0) != CE_None)
      return false;
  }
  return true;
}

}  // namespace

Status writeClasses(const std::filesystem::path& path, const PictureLattice& lattice, const ClassGrid& grid,
                    std::span<const uint8_t> classes, uint8_t no_data) {
  CHECK_EQ(classes.size(), size_t{grid.columns} * grid.rows);
  registerGdalDrivers();
  auto map = LatticeMap::of(lattice);
  if (!map.ok()) return map.error();
  PendingFile pending(path);
  const GdalOutput output{pending.path()};
  GdalMessages messages;
  const char* const options[] = {"COMPRESS=DEFLATE", "BIGTIFF=IF_SAFER", nullptr};
  GdalDataset dataset(GDALCreate(GDALGetDriverByName("GTiff"), pending.path().c_str(), static_cast<int>(grid.columns),
                                 static_cast<int>(grid.rows), 1, GDT_Byte, options));
  if (!dataset || !place(dataset.get(), *map, grid)) return unwritten(path, messages);
  GDALRasterBandH band = GDALGetRasterBand(dataset.get(), 1);
  if (GDALSetRasterNoDataValue(band, no_data) != CE_None || !writeRows(band, grid, classes))
    return unwritten(path, messages);
  GDALClose(dataset.release());
  if (messages.hasErrors()) return unwritten(path, messages);
  return pending.commit();
}

}  // namespace foreland::terrain
