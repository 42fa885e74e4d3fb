#include "terrain/dem/warp/sample_places.h"

#include <ogr_srs_api.h>

#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "terrain/dem/formats/gdal_georeference.h"
#include "terrain/dem/formats/gdal_messages.h"
#include "terrain/dem/pictures/lattice_map.h"

namespace foreland::terrain {

namespace {

constexpr double kWhole = 1e-6;  // samples: more than rounding makes of a whole one
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

glm::dvec2 onMap(const std::array<double, 6>& t, glm::dvec2 p) {
  return {t[0] + p.x * t[1] + p.y * t[2], t[3] + p.x * t[4] + p.y * t[5]};
}

glm::dvec2 offMap(const std::array<double, 6>& t, glm::dvec2 p) {
  const double dx = p.x - t[0], dy = p.y - t[3], determinant = t[1] * t[5] - t[2] * t[4];
  return {(dx * t[5] - dy * t[2]) / determinant, (dy * t[1] - dx * t[4]) / determinant};
}

glm::dvec2 wholeIfNear(glm::dvec2 p) {
  const glm::dvec2 whole = glm::round(p);
  return {std::fabs(p.x - whole.x) < kWhole ? whole.x : p.x, std::fabs(p.y - whole.y) < kWhole ? whole.y : p.y};
}

GdalReferenceSystem systemOf(const std::string& wkt) {
  GdalReferenceSystem crs(OSRNewSpatialReference(withoutHeights(wkt).c_str()));
  if (crs) OSRSetAxisMappingStrategy(crs.get(), OAMS_TRADITIONAL_GIS_ORDER);
  return crs;
}

bool isSame(void* a, void* b) {
  const char* const options[] = {"IGNORE_DATA_AXIS_TO_SRS_AXIS_MAPPING=YES", "CRITERION=EQUIVALENT", nullptr};
  return OSRIsSameEx(a, b, options);
}

struct DestroyTransformation {
  void operator()(void* t) const { OCTDestroyCoordinateTransformation(t); }
};
using Owner = std::unique_ptr<void, DestroyTransformation>;

Owner transformation(void* from, void* to, bool may_be_ballpark) {
  const std::unique_ptr<OGRCoordinateTransformationOptions, decltype(&OCTDestroyCoordinateTransformationOptions)>
      options(OCTNewCoordinateTransformationOptions(), OCTDestroyCoordinateTransformationOptions);
  OCTCoordinateTransformationOptionsSetBallparkAllowed(options.get(), may_be_ballpark);
  return Owner(OCTNewCoordinateTransformationEx(from, to, options.get()));
}

std::string nameOf(void* crs) {
  const char* name = OSRGetName(crs);
  return name == nullptr ? "unnamed" : name;
}

}  // namespace

struct SamplePlaces::Transformation {
  Owner to_raster, to_lattice;

  static void apply(void* t, std::span<glm::dvec2> positions) {
    const GdalMessages silence;
    std::vector<double> x, y;
    for (const glm::dvec2& p : positions) x.push_back(p.x), y.push_back(p.y);
    std::vector<int> known(positions.size());
    OCTTransformEx(t, static_cast<int>(positions.size()), x.data(), y.data(), nullptr, known.data());
    for (size_t i = 0; i < positions.size(); ++i)
      positions[i] =
          known[i] && std::isfinite(x[i]) && std::isfinite(y[i]) ? glm::dvec2(x[i], y[i]) : glm::dvec2(kNone, kNone);
  }
};

Result<SamplePlaces> SamplePlaces::of(const LatticePlace& lattice, const Georeference& map, glm::uvec2 size,
                                      const std::string& name) {
  const GdalMessages silence;
  const std::string both = name + " and " + lattice.name;
  if (!map.has_transform)
    return Error{ErrorCode::kInvalidArgument, name + ": it states no position, so where it lies on " + lattice.name +
                                                  " is unknown; give it one with gdal_translate -a_srs -a_ullr"};
  const auto lattice_map = LatticeMap::of({.frame = lattice.frame, .crs_wkt = lattice.crs_wkt});
  if (!lattice_map)
    return Error{ErrorCode::kUnsupported,
                 both +
                     ": a scene whose latitude and longitude were flattened takes no inputs of "
                     "other grids; leave --frame planar out"};
  SamplePlaces out;
  const auto t = lattice_map->transform({0, 0}, glm::dvec2(1));
  out.lattice_ = {t[0], t[1], -t[2], t[3], t[4], -t[5]};
  out.raster_ = map.transform;
  GdalReferenceSystem raster_crs;
  if (!map.crs_wkt.empty())
    raster_crs = systemOf(map.crs_wkt);
  else if (map.kind == MapKind::kGeographic)
    raster_crs = systemOf(SRS_WKT_WGS84_LAT_LONG);
  GdalReferenceSystem lattice_crs;
  if (lattice_map->referenceSystem() != nullptr)
    lattice_crs = systemOf(lattice.crs_wkt.empty() ? SRS_WKT_WGS84_LAT_LONG : lattice.crs_wkt);
  if (!raster_crs != !lattice_crs)
    return Error{ErrorCode::kInvalidArgument, both +
                                                  ": one of them has no reference system, so where they lie to each "
                                                  "other is unknown; name it with gdal_translate -a_srs"};
  if (!raster_crs) {
    if (map.unit != 1)
      for (double& v : out.raster_) v *= map.unit;
    return out;
  }
  const auto longitudes = [](void* crs, const std::array<double, 6>& on, glm::uvec2 samples) {
    if (!OSRIsGeographic(crs)) return Longitudes{};
    return Longitudes{2 * std::numbers::pi / OSRGetAngularUnits(crs, nullptr), onMap(on, 0.5 * glm::dvec2(samples)).x};
  };
  out.raster_longitudes_ = longitudes(raster_crs.get(), out.raster_, size);
  out.lattice_longitudes_ = longitudes(lattice_crs.get(), out.lattice_, {lattice.width, lattice.height});
  if (isSame(raster_crs.get(), lattice_crs.get())) return out;
  auto known = std::make_shared<Transformation>();
  for (const bool may_be_ballpark : {false, true}) {
    known->to_raster = transformation(lattice_crs.get(), raster_crs.get(), may_be_ballpark);
    known->to_lattice = transformation(raster_crs.get(), lattice_crs.get(), may_be_ballpark);
    out.is_ballpark_ = may_be_ballpark;
    if (known->to_raster && known->to_lattice) break;
  }
  if (!known->to_raster || !known->to_lattice)
    return Error{ErrorCode::kUnsupported, both + ": no transformation is known between their reference systems (" +
                                              nameOf(raster_crs.get()) + "; " + nameOf(lattice_crs.get()) +
                                              "); if one of them is wrong, correct it with gdal_translate -a_srs"};
  out.transformation_ = std::move(known);
  return out;
}

void SamplePlaces::toSamples(std::span<glm::dvec2> positions) const {
  for (glm::dvec2& p : positions) p = onMap(lattice_, p);
  if (transformation_) Transformation::apply(transformation_->to_raster.get(), positions);
  toIndices(raster_, raster_longitudes_, positions);
}

void SamplePlaces::toLattice(std::span<glm::dvec2> positions) const {
  for (glm::dvec2& p : positions) p = onMap(raster_, p);
  if (transformation_) Transformation::apply(transformation_->to_lattice.get(), positions);
  toIndices(lattice_, lattice_longitudes_, positions);
}

// From map positions, on the turn of longitudes that is nearest to the map's middle.
void SamplePlaces::toIndices(const std::array<double, 6>& map, const Longitudes& longitudes,
                             std::span<glm::dvec2> positions) {
  for (glm::dvec2& p : positions) {
    if (longitudes.turn > 0) p.x -= longitudes.turn * std::round((p.x - longitudes.middle) / longitudes.turn);
    p = wholeIfNear(offMap(map, p));
  }
}

}  // namespace foreland::terrain
