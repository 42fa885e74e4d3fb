#include "terrain/dem/pictures/lattice_map.h"

#include <ogr_srs_api.h>

#include <numbers>

#include "terrain/dem/formats/gdal_messages.h"

namespace foreland::terrain {

Result<LatticeMap> LatticeMap::of(const PictureLattice& lattice) {
  const GdalMessages silence;
  const proto::Frame& f = lattice.frame;
  const bool is_geographic = f.kind == proto::FrameKind::kGeographic;
  LatticeMap map;
  if (!lattice.crs_wkt.empty())
    map.crs_.reset(OSRNewSpatialReference(lattice.crs_wkt.c_str()));
  else if (is_geographic)
    map.crs_.reset(OSRNewSpatialReference(SRS_WKT_WGS84_LAT_LONG));
  if (map.crs_) OSRSetAxisMappingStrategy(map.crs_.get(), OAMS_TRADITIONAL_GIS_ORDER);
  if (is_geographic) {
    const double unit = OSRGetAngularUnits(map.crs_.get(), nullptr);
    const double meridian = OSRGetPrimeMeridian(map.crs_.get(), nullptr) * std::numbers::pi / 180;
    map.origin_ = glm::dvec2(f.longitude0_rad - meridian, f.latitude0_rad) / unit;
    map.axis_x_ = {f.longitude_step_rad / unit, 0};
    map.axis_y_ = {0, f.latitude_step_rad / unit};
    return map;
  }
  if (map.crs_ && OSRIsGeographic(map.crs_.get()))
    return Error{ErrorCode::kUnsupported,
                 "a scene whose latitude and longitude were flattened takes no pictures; leave --frame planar out"};
  const double unit = map.crs_ ? OSRGetLinearUnits(map.crs_.get(), nullptr) : 1;
  map.origin_ = (f.map_origin_m - f.axis_x_m * f.anchor.x - f.axis_y_m * f.anchor.y) / unit;
  map.axis_x_ = f.axis_x_m / unit;
  map.axis_y_ = f.axis_y_m / unit;
  return map;
}

std::array<double, 6> LatticeMap::transform(const glm::dvec2& upper_left, const glm::dvec2& texel) const {
  const glm::dvec2 corner = origin_ + axis_x_ * upper_left.x + axis_y_ * upper_left.y;
  return {corner.x, axis_x_.x * texel.x, -axis_y_.x * texel.y, corner.y, axis_x_.y * texel.x, -axis_y_.y * texel.y};
}

}  // namespace foreland::terrain
