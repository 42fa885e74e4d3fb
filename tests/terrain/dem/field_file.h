// Elevation files of formulas, in any reference system.
#pragma once

#include <gdal.h>
#include <gtest/gtest.h>
#include <ogr_srs_api.h>

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "terrain/dem/formats/gdal_raster.h"

namespace foreland::terrain {

using HeightAt = std::function<double(double x, double y)>;  // of the map

struct Field {
  std::string crs = "EPSG:32632";
  double west = 500000, north = 5150000, step = 30;  // of the first sample's middle
  int columns = 41, rows = 37;
  HeightAt height;
};

inline std::string writeField(const std::string& path, const Field& f) {
  registerGdalDrivers();
  GDALDatasetH dataset =
      GDALCreate(GDALGetDriverByName("GTiff"), path.c_str(), f.columns, f.rows, 1, GDT_Float32, nullptr);
  OGRSpatialReferenceH crs = OSRNewSpatialReference(nullptr);
  EXPECT_EQ(OSRSetFromUserInput(crs, f.crs.c_str()), OGRERR_NONE);
  OSRSetAxisMappingStrategy(crs, OAMS_TRADITIONAL_GIS_ORDER);
  std::array<double, 6> t{f.west - 0.5 * f.step, f.step, 0, f.north + 0.5 * f.step, 0, -f.step};
  GDALSetGeoTransform(dataset, t.data());
  GDALSetSpatialRef(dataset, crs);
  OSRDestroySpatialReference(crs);
  std::vector<float> heights;
  for (int row = 0; row < f.rows; ++row)
    for (int column = 0; column < f.columns; ++column)
      heights.push_back(static_cast<float>(f.height(f.west + column * f.step, f.north - row * f.step)));
  EXPECT_EQ(GDALRasterIO(GDALGetRasterBand(dataset, 1), GF_Write, 0, 0, f.columns, f.rows, heights.data(), f.columns,
                         f.rows, GDT_Float32, 0, 0),
            CE_None);
  GDALClose(dataset);
  return path;
}

}  // namespace foreland::terrain
