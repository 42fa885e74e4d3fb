#include "terrain/dem/formats/true_map.h"

#include <fmt/format.h>
#include <gdal.h>
#include <gdal_utils.h>
#include <ogr_srs_api.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <optional>
#include <utility>

#include "terrain/dem/formats/gdal_georeference.h"
#include "terrain/dem/formats/gdal_messages.h"
#include "terrain/geo/geodesy.h"

namespace foreland::terrain {

namespace {

// A view of `from`, which must outlive it: in a reference system, or in that of its control points if `to` is empty.
GdalDataset warped(GDALDatasetH from, const std::string& to) {
  std::vector<std::string> words{"-of", "VRT", "-r", "bilinear", "-ot", "Float32", "-dstnodata", "nan"};
  if (!to.empty()) words.insert(words.end(), {"-t_srs", to});
  GDALWarpAppOptions* options = GDALWarpAppOptionsNew(gdalWords(words).get(), nullptr);
  GdalDataset out(options == nullptr ? nullptr : GDALWarp("", nullptr, 1, &from, options, nullptr));
  GDALWarpAppOptionsFree(options);
  return out;
}

bool hasTransform(GDALDatasetH dataset) {
  std::array<double, 6> t{};
  return GDALGetGeoTransform(dataset, t.data()) == CE_None;
}

GdalReferenceSystem geographicOf(OGRSpatialReferenceH crs) {
  GdalReferenceSystem out(OSRCloneGeogCS(crs));
  if (out) OSRSetAxisMappingStrategy(out.get(), OAMS_TRADITIONAL_GIS_ORDER);
  return out;
}

// How many metres of a projected map a metre of ground takes in the middle of the data, along the axis that is farther
// off: 1 in most maps, 2 in Mercator's at 60 degrees. Nothing where it cannot be told.
std::optional<double> scaleOfMap(GDALDatasetH dataset) {
  constexpr double kStep_m = 100;  // of the map, either way
  const GdalMessages silence;
  std::array<double, 6> t{};
  OGRSpatialReferenceH crs = GDALGetSpatialRef(dataset);
  if (crs == nullptr || !OSRIsProjected(crs) || GDALGetGeoTransform(dataset, t.data()) != CE_None) return std::nullopt;
  const GdalReferenceSystem geographic = geographicOf(crs);
  if (!geographic) return std::nullopt;
  const std::unique_ptr<void, decltype(&OCTDestroyCoordinateTransformation)> transformation(
      OCTNewCoordinateTransformation(crs, geographic.get()), OCTDestroyCoordinateTransformation);
  if (!transformation) return std::nullopt;
  const double column = 0.5 * GDALGetRasterXSize(dataset), row = 0.5 * GDALGetRasterYSize(dataset);
  const double x = t[0] + column * t[1] + row * t[2], y = t[3] + column * t[4] + row * t[5];
  const double step = kStep_m / OSRGetLinearUnits(crs, nullptr);
  std::array<double, 4> longitude{x - step, x + step, x, x}, latitude{y, y, y - step, y + step};
  if (!OCTTransform(transformation.get(), 4, longitude.data(), latitude.data(), nullptr)) return std::nullopt;
  const double unit = OSRGetAngularUnits(geographic.get(), nullptr);
  const glm::dvec2 metres =
      unit * metresPerRadian(ellipsoidOf(geographic.get()), 0.5 * (latitude[2] + latitude[3]) * unit);
  const auto scale = [&](size_t a, size_t b) {
    return 2 * kStep_m / glm::length(metres * glm::dvec2(longitude[b] - longitude[a], latitude[b] - latitude[a]));
  };
  const double along_x = scale(0, 1), along_y = scale(2, 3);
  if (!std::isfinite(along_x) || !std::isfinite(along_y)) return std::nullopt;
  return std::fabs(along_x - 1) > std::fabs(along_y - 1) ? along_x : along_y;
}

}  // namespace

Result<TrueMap> onTrueMap(GdalDataset dataset, const std::string& name, MapUse use) {
  constexpr double kMaxOff = 0.005;
  TrueMap out{{}, std::move(dataset), {}};
  const auto replace = [&](GdalDataset by) { out.sources.push_back(std::exchange(out.dataset, std::move(by))); };
  if (const int points = GDALGetGCPCount(out.dataset.get()); points > 0 && !hasTransform(out.dataset.get())) {
    GdalMessages messages;
    GdalDataset placed = warped(out.dataset.get(), "");
    if (!placed)
      return Error{ErrorCode::kUnsupported, fmt::format("{}: its {} control points do not place it (GDAL says: {}); "
                                                        "try gdalwarp -tps -dstnodata -9999 {} placed.tif",
                                                        name, points, messages.errors(), name)};
    replace(std::move(placed));
    out.notes.push_back(fmt::format("it is placed by {} control points, and was warped to their map", points));
  }
  if (use == MapUse::kPlace) return out;
  const std::optional<double> scale = scaleOfMap(out.dataset.get());
  if (!scale || std::fabs(*scale - 1) <= kMaxOff) return out;
  OGRSpatialReferenceH crs = GDALGetSpatialRef(out.dataset.get());
  const std::string found =
      fmt::format("its map ({}) shows distances {:.3g} times as long as they are here", OSRGetName(crs), *scale);
  if (use == MapUse::kKeep) {
    out.notes.push_back(found + ", and slopes as much flatter");
    return out;
  }
  GdalDataset placed = warped(out.dataset.get(), wktOf(geographicOf(crs).get()));
  if (!placed) return out;
  replace(std::move(placed));
  out.notes.push_back(found + ", so it was warped to latitude and longitude (--frame projected keeps the map)");
  return out;
}

}  // namespace foreland::terrain
