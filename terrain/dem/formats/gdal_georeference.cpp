#include "terrain/dem/formats/gdal_georeference.h"

#include <cpl_conv.h>
#include <gdal.h>
#include <ogr_srs_api.h>

#include <cmath>
#include <numbers>

#include "terrain/dem/formats/gdal_dataset.h"
#include "terrain/dem/formats/gdal_messages.h"

namespace foreland::terrain {

std::string wktOf(OGRSpatialReferenceH crs) {
  const char* const options[] = {"FORMAT=WKT2_2019", nullptr};
  char* text = nullptr;
  if (OSRExportToWktEx(crs, &text, options) != OGRERR_NONE) OSRExportToWkt(crs, &text);
  const std::string wkt = text != nullptr ? text : "";
  CPLFree(text);
  return wkt;
}

Ellipsoid ellipsoidOf(OGRSpatialReferenceH crs) {
  OGRErr failed = OGRERR_NONE;
  const double semi_major = OSRGetSemiMajor(crs, &failed);
  if (failed != OGRERR_NONE) return {};
  const double inverse = OSRGetInvFlattening(crs, &failed);
  return {semi_major, inverse > 0 ? 1 / inverse : 0.0};
}

namespace {

// Reads the map positions of sample centres. False if the dataset has none, or a degenerate transform.
bool readTransform(GDALDatasetH dataset, Georeference& out, std::vector<std::string>& notes) {
  std::array<double, 6> t{};
  if (GDALGetGeoTransform(dataset, t.data()) != CE_None) return false;
  bool finite = true;
  for (const double v : t) finite = finite && std::isfinite(v) && std::fabs(v) < 1e12;
  if (!finite || t[1] * t[5] - t[2] * t[4] == 0) {
    notes.push_back("its geotransform is degenerate and was ignored");
    return false;
  }
  t[0] += 0.5 * (t[1] + t[2]);
  t[3] += 0.5 * (t[4] + t[5]);
  out.transform = t;
  return true;
}

void readGeographic(OGRSpatialReferenceH crs, Georeference& out) {
  out.kind = MapKind::kGeographic;
  out.unit = OSRGetAngularUnits(crs, nullptr);
  out.prime_meridian_rad = OSRGetPrimeMeridian(crs, nullptr) * std::numbers::pi / 180;
  out.ellipsoid = ellipsoidOf(crs);
}

// What a map says of its heights is in the file's own reference system, of which a warped view may have lost it.
bool saysOfHeights(OGRSpatialReferenceH crs) { return OSRIsCompound(crs) || OSRGetAxesCount(crs) == 3; }

void readVerticalUnit(OGRSpatialReferenceH crs, Georeference& out) {
  if (!OSRIsCompound(crs)) return;
  char* name = nullptr;
  out.vertical_unit = OSRGetTargetLinearUnits(crs, "VERT_CS", &name);
  if (name != nullptr) out.vertical_unit_name = name;
  if (!(*out.vertical_unit > 0)) out.vertical_unit.reset();
}

// The reference system without its vertical part; null if that fails.
GdalReferenceSystem horizontalOf(const std::string& wkt) {
  GdalReferenceSystem crs(OSRNewSpatialReference(wkt.c_str()));
  if (!crs || !saysOfHeights(crs.get())) return crs;
  if (OSRIsCompound(crs.get())) OSRStripVertical(crs.get());
  if (OSRGetAxesCount(crs.get()) == 3 && OSRDemoteTo2D(crs.get(), nullptr) != OGRERR_NONE) crs.reset();
  return crs;
}

}  // namespace

void readHeightStatement(OGRSpatialReferenceH crs, Georeference& out) {
  if (crs == nullptr) return;
  readVerticalUnit(crs, out);
  if (saysOfHeights(crs)) out.heights_wkt = wktOf(crs);
}

std::string withoutHeights(const std::string& wkt) {
  const GdalReferenceSystem flat = horizontalOf(wkt);
  return flat ? wktOf(flat.get()) : wkt;
}

Result<Georeference> readGeoreference(GDALDatasetH dataset, const std::string& name, std::vector<std::string>& notes) {
  Georeference out;
  out.has_transform = readTransform(dataset, out, notes);
  OGRSpatialReferenceH crs = GDALGetSpatialRef(dataset);
  if (crs == nullptr) return out;
  if (!out.has_transform) {
    notes.push_back("it names a reference system but no position in it; the system was ignored");
    return out;
  }
  const char* crs_name = OSRGetName(crs);
  out.crs_name = crs_name != nullptr ? crs_name : "unnamed";
  if (OSRIsGeocentric(crs) || OSRIsDerivedGeographic(crs))
    return Error{ErrorCode::kUnsupported, name + ": its reference system (" + out.crs_name +
                                              ") is neither projected nor plain latitude and longitude; "
                                              "convert it first, e.g. gdalwarp -t_srs EPSG:4326 -dstnodata -9999"};
  out.crs_wkt = wktOf(crs);
  readHeightStatement(crs, out);
  if (OSRIsGeographic(crs)) {
    readGeographic(crs, out);
  } else if (OSRIsProjected(crs) || OSRIsLocal(crs)) {
    out.kind = MapKind::kProjected;
    out.unit = OSRGetLinearUnits(crs, nullptr);
  }
  if (!(out.unit > 0))
    return Error{ErrorCode::kMalformed,
                 name + ": its reference system has no unit; name one with gdal_translate -a_srs"};
  return out;
}

bool isSameReferenceSystem(const Georeference& a, const Georeference& b) {
  if (a.kind != b.kind) return false;
  if (a.crs_wkt == b.crs_wkt) return true;
  if (a.kind == MapKind::kGeographic)  // datums that share the ellipsoid differ by less than a sample
    return a.unit == b.unit && a.prime_meridian_rad == b.prime_meridian_rad &&
           std::fabs(a.ellipsoid.semi_major_m - b.ellipsoid.semi_major_m) < 0.5;
  const GdalMessages silence;
  const GdalReferenceSystem left = horizontalOf(a.crs_wkt), right = horizontalOf(b.crs_wkt);
  const char* const options[] = {"IGNORE_DATA_AXIS_TO_SRS_AXIS_MAPPING=YES", "CRITERION=EQUIVALENT", nullptr};
  return left && right && OSRIsSameEx(left.get(), right.get(), options);
}

}  // namespace foreland::terrain
