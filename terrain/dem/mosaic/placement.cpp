#include "terrain/dem/mosaic/placement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace foreland::terrain {

namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kHalfPi = std::numbers::pi / 2;
constexpr double kMaxFlattened_rad = 5 * kDegree;

glm::dvec2 mapPosition(const Georeference& map, double column, double row) {
  const auto& t = map.transform;
  return {t[0] + column * t[1] + row * t[2], t[3] + column * t[4] + row * t[5]};
}

bool fitsGlobe(const Georeference& map, const Extent& extent) {
  const glm::dvec2 a = mapPosition(map, 0, 0), b = mapPosition(map, extent.width - 1.0, extent.height - 1.0);
  return map.transform[2] == 0 && map.transform[4] == 0 && std::max(std::fabs(a.y), std::fabs(b.y)) <= 90.0000001 &&
         std::min(a.x, b.x) >= -360 && std::max(a.x, b.x) <= 720;
}

// Metres would make mountains as steep as needles; so the numbers are degrees.
bool looksLikeDegrees(const Georeference& map, const Extent& extent) {
  const glm::dvec2 a = mapPosition(map, 0, 0), b = mapPosition(map, extent.width - 1.0, extent.height - 1.0);
  const double side = std::max(std::fabs(b.x - a.x), std::fabs(b.y - a.y));
  return fitsGlobe(map, extent) && double{extent.highest_m} - extent.lowest_m > 0.5 * side;
}

Georeference asDegrees(Georeference map) {
  map.kind = MapKind::kGeographic;
  map.unit = kDegree;
  return map;
}

Error overrideError(const std::string& name, const std::string& why) {
  return {ErrorCode::kInvalidArgument, name + ": " + why};
}

}  // namespace

Result<Georeference> resolveMap(const Georeference& stated, const Extent& extent, const OpenOptions& options,
                                std::vector<std::string>& notes) {
  if (options.spacing_m && !(*options.spacing_m > 0 && *options.spacing_m < 1e7))
    return overrideError(extent.name, fmt::format("--spacing {:g} is no distance in metres", *options.spacing_m));
  if (!stated.crs_wkt.empty()) {
    if (options.spacing_m)
      return overrideError(extent.name,
                           "--spacing is for files without a reference system, and this one has " + stated.crs_name);
    return stated;
  }
  Georeference map = stated;
  if (options.frame == FrameChoice::kGeographic) {
    if (!map.has_transform || map.kind == MapKind::kProjected || !fitsGlobe(map, extent))
      return overrideError(extent.name, "--frame geographic needs coordinates in degrees, and this file has none");
    return asDegrees(map);
  }
  if (options.spacing_m) {
    map.transform = {0, *options.spacing_m, 0, 0, 0, -*options.spacing_m};
    map.kind = MapKind::kProjected;
    return map;
  }
  if (map.kind == MapKind::kProjected) return map;
  map.kind = MapKind::kProjected;
  if (!map.has_transform) {
    notes.push_back("it states no distance between its samples; taken as 1 m (--spacing M sets it)");
    return map;
  }
  if (options.frame == FrameChoice::kAuto && looksLikeDegrees(map, extent)) {
    notes.push_back(
        "it names no reference system; its coordinates look like degrees and are taken as longitude and latitude on "
        "WGS84 "
        "(--frame planar takes them as metres)");
    return asDegrees(map);
  }
  notes.push_back(
      fmt::format("it names no reference system; its coordinates are taken as metres, {:g} m between samples",
                  std::hypot(map.transform[1], map.transform[4])));
  return map;
}

namespace {

// Of the four ways to count rows and columns two are right-handed; the one whose axes point most east and north is
// taken.
void orient(const Georeference& map, RasterPlacement& out, glm::dvec2& axis_x, glm::dvec2& axis_y) {
  const glm::dvec2 column{map.transform[1], map.transform[4]}, row{map.transform[2], map.transform[5]};
  const bool mirrored =
      column.x * row.y - column.y * row.x > 0;  // an image, seen from above, has rows clockwise of columns
  const glm::dvec2 up = mirrored ? row : -row;
  const bool turned = column.x + up.y < 0;
  axis_x = turned ? -column : column;
  axis_y = turned ? -up : up;
  out.is_column_reversed = turned;
  out.is_row_reversed = mirrored == turned;
}

// Map position of lattice (x, y).
glm::dvec2 latticePosition(const Georeference& map, const Extent& extent, const RasterPlacement& out, double x,
                           double y) {
  return mapPosition(map, out.is_column_reversed ? extent.width - 1.0 - x : x,
                     out.is_row_reversed ? extent.height - 1.0 - y : y);
}

void makePlanar(const Georeference& map, const Extent& extent, RasterPlacement& out) {
  orient(map, out, out.frame.axis_x_m, out.frame.axis_y_m);
  out.frame.kind = proto::FrameKind::kPlanar;
  out.frame.axis_x_m *= map.unit;
  out.frame.axis_y_m *= map.unit;
  out.frame.anchor = {extent.width / 2, extent.height / 2};
  out.frame.map_origin_m = latticePosition(map, extent, out, out.frame.anchor.x, out.frame.anchor.y) * map.unit;
}

Status makeGeographic(const Georeference& map, const Extent& extent, RasterPlacement& out) {
  glm::dvec2 axis_x, axis_y;
  orient(map, out, axis_x, axis_y);
  if (axis_x.y != 0 || axis_y.x != 0)
    return Error{ErrorCode::kUnsupported, extent.name +
                                              ": its rows do not follow the parallels; straighten it first with "
                                              "gdalwarp -t_srs EPSG:4326 -dstnodata -9999"};
  proto::Frame& frame = out.frame;
  frame.kind = proto::FrameKind::kGeographic;
  frame.semi_major_m = map.ellipsoid.semi_major_m;
  frame.flattening = map.ellipsoid.flattening;
  frame.latitude_step_rad = axis_y.y * map.unit;
  frame.longitude_step_rad = axis_x.x * map.unit;
  const glm::dvec2 corner = latticePosition(map, extent, out, 0, 0) * map.unit;
  frame.longitude0_rad = corner.x + map.prime_meridian_rad;
  frame.latitude0_rad = corner.y;
  const double north = frame.latitude0_rad + (extent.height - 1.0) * frame.latitude_step_rad;
  if (frame.latitude0_rad < -kHalfPi - 1e-9 || north > kHalfPi + 1e-9)
    return Error{ErrorCode::kMalformed,
                 fmt::format("{}: its latitudes reach from {:.3f} to {:.3f} degrees, past a pole; correct its "
                             "position with gdal_translate -a_ullr",
                             extent.name, frame.latitude0_rad / kDegree, north / kDegree)};
  const uint32_t middle_row = extent.height / 2, middle_column = extent.width / 2;
  frame.origin = {frame.latitude0_rad + middle_row * frame.latitude_step_rad,
                  frame.longitude0_rad + middle_column * frame.longitude_step_rad, 0};
  return {};
}

// Degrees flattened at the middle latitude.
Result<Georeference> flatten(const Georeference& map, const Extent& extent) {
  const glm::dvec2 span =
      (mapPosition(map, extent.width - 1.0, extent.height - 1.0) - mapPosition(map, 0, 0)) * map.unit;
  if (std::max(std::fabs(span.x), std::fabs(span.y)) > kMaxFlattened_rad)
    return overrideError(
        extent.name,
        fmt::format("--frame planar would flatten {:.1f} x {:.1f} degrees, too much of the globe; leave it out",
                    std::fabs(span.x) / kDegree, std::fabs(span.y) / kDegree));
  const double latitude = mapPosition(map, extent.width * 0.5, extent.height * 0.5).y * map.unit;
  const glm::dvec2 scale = metresPerRadian(map.ellipsoid, latitude) * map.unit;
  Georeference flat = map;
  flat.kind = MapKind::kProjected;
  flat.unit = 1;
  for (const size_t i : {0u, 1u, 2u}) flat.transform[i] *= scale.x;
  for (const size_t i : {3u, 4u, 5u}) flat.transform[i] *= scale.y;
  return flat;
}

}  // namespace

Result<RasterPlacement> placeRaster(const Georeference& resolved, const Extent& extent, const OpenOptions& options) {
  RasterPlacement out;
  Georeference map = resolved;
  if (options.frame == FrameChoice::kGeographic && map.kind != MapKind::kGeographic)
    return overrideError(
        extent.name,
        "--frame geographic cannot be meant for map coordinates (" + map.crs_name +
            "); convert the file first with gdalwarp -t_srs EPSG:4326 -dstnodata -9999, or leave --frame out");
  if (options.frame == FrameChoice::kPlanar && map.kind == MapKind::kGeographic) {
    Result<Georeference> flat = flatten(map, extent);
    if (!flat.ok()) return flat.error();
    map = *flat;
    out.notes.push_back(
        "latitude and longitude were flattened at the middle latitude; the curvature of the ground is lost");
  }
  if (map.kind == MapKind::kGeographic) {
    if (Status s = makeGeographic(map, extent, out); !s.ok()) return s.error();
  } else {
    makePlanar(map, extent, out);
  }
  if (Status s = out.frame.validate(extent.width - 1.0, extent.height - 1.0); !s.ok())
    return Error{s.error().code,
                 extent.name + ": " + s.error().message + "; correct its position with gdal_translate -a_ullr"};
  return out;
}

}  // namespace foreland::terrain
