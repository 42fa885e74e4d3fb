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

glm::dvec2 mapPosition(const Georeference& place, double column, double row) {
  const auto& t = place.transform;
  return {t[0] + column * t[1] + row * t[2], t[3] + column * t[4] + row * t[5]};
}

bool fitsGlobe(const Georeference& place, const Extent& extent) {
  const glm::dvec2 a = mapPosition(place, 0, 0), b = mapPosition(place, extent.width - 1.0, extent.height - 1.0);
  return place.transform[2] == 0 && place.transform[4] == 0 && std::max(std::fabs(a.y), std::fabs(b.y)) <= 90.0000001 &&
         std::min(a.x, b.x) >= -360 && std::max(a.x, b.x) <= 720;
}

// Metres would make mountains as steep as needles; so the numbers are degrees.
bool looksLikeDegrees(const Georeference& place, const Extent& extent) {
  const glm::dvec2 a = mapPosition(place, 0, 0), b = mapPosition(place, extent.width - 1.0, extent.height - 1.0);
  const double side = std::max(std::fabs(b.x - a.x), std::fabs(b.y - a.y));
  return fitsGlobe(place, extent) && double{extent.highest_m} - extent.lowest_m > 0.5 * side;
}

Georeference asDegrees(Georeference place) {
  place.kind = MapKind::kGeographic;
  place.unit = kDegree;
  return place;
}

Error overrideError(const std::string& name, const std::string& why) {
  return {ErrorCode::kInvalidArgument, name + ": " + why};
}

}  // namespace

Result<Georeference> settleMap(const Georeference& said, const Extent& extent, const OpenOptions& options,
                               std::vector<std::string>& notes) {
  if (options.spacing_m && !(*options.spacing_m > 0 && *options.spacing_m < 1e7))
    return overrideError(extent.name, fmt::format("--spacing {:g} is no distance in metres", *options.spacing_m));
  if (!said.crs_wkt.empty()) {
    if (options.spacing_m)
      return overrideError(extent.name,
                           "--spacing is for files without a reference system, and this one has " + said.crs_name);
    return said;
  }
  Georeference place = said;
  if (options.frame == FrameChoice::kGeographic) {
    if (!place.has_transform || place.kind == MapKind::kProjected || !fitsGlobe(place, extent))
      return overrideError(extent.name, "--frame geographic needs coordinates in degrees, and this file has none");
    return asDegrees(place);
  }
  if (options.spacing_m) {
    place.transform = {0, *options.spacing_m, 0, 0, 0, -*options.spacing_m};
    place.kind = MapKind::kProjected;
    return place;
  }
  if (place.kind == MapKind::kProjected) return place;
  place.kind = MapKind::kProjected;
  if (!place.has_transform) {
    notes.push_back("it states no distance between its samples; taken as 1 m (--spacing M sets it)");
    return place;
  }
  if (options.frame == FrameChoice::kAuto && looksLikeDegrees(place, extent)) {
    notes.push_back(
        "it names no reference system; its coordinates look like degrees and are taken as longitude and latitude on "
        "WGS84 "
        "(--frame planar takes them as metres)");
    return asDegrees(place);
  }
  notes.push_back(
      fmt::format("it names no reference system; its coordinates are taken as metres, {:g} m between samples",
                  std::hypot(place.transform[1], place.transform[4])));
  return place;
}

namespace {

// Of the four ways to count rows and columns two are right-handed; the one whose axes point most east and north is
// taken.
void orient(const Georeference& place, Placement& out, glm::dvec2& axis_x, glm::dvec2& axis_y) {
  const glm::dvec2 column{place.transform[1], place.transform[4]}, row{place.transform[2], place.transform[5]};
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
glm::dvec2 latticePosition(const Georeference& place, const Extent& extent, const Placement& out, double x, double y) {
  return mapPosition(place, out.is_column_reversed ? extent.width - 1.0 - x : x,
                     out.is_row_reversed ? extent.height - 1.0 - y : y);
}

void makePlanar(const Georeference& place, const Extent& extent, Placement& out) {
  orient(place, out, out.frame.axis_x_m, out.frame.axis_y_m);
  out.frame.kind = proto::FrameKind::kPlanar;
  out.frame.axis_x_m *= place.unit;
  out.frame.axis_y_m *= place.unit;
  out.frame.anchor = {extent.width / 2, extent.height / 2};
  out.frame.map_origin_m = latticePosition(place, extent, out, out.frame.anchor.x, out.frame.anchor.y) * place.unit;
}

Status makeGeographic(const Georeference& place, const Extent& extent, Placement& out) {
  glm::dvec2 axis_x, axis_y;
  orient(place, out, axis_x, axis_y);
  if (axis_x.y != 0 || axis_y.x != 0)
    return Error{
        ErrorCode::kUnsupported,
        extent.name + ": its rows do not follow the parallels; straighten it first with gdalwarp -t_srs EPSG:4326"};
  proto::Frame& frame = out.frame;
  frame.kind = proto::FrameKind::kGeographic;
  frame.semi_major_m = place.ellipsoid.semi_major_m;
  frame.flattening = place.ellipsoid.flattening;
  frame.latitude_step_rad = axis_y.y * place.unit;
  frame.longitude_step_rad = axis_x.x * place.unit;
  const glm::dvec2 corner = latticePosition(place, extent, out, 0, 0) * place.unit;
  frame.longitude0_rad = corner.x + place.prime_meridian_rad;
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
Result<Georeference> flatten(const Georeference& place, const Extent& extent) {
  const glm::dvec2 span =
      (mapPosition(place, extent.width - 1.0, extent.height - 1.0) - mapPosition(place, 0, 0)) * place.unit;
  if (std::max(std::fabs(span.x), std::fabs(span.y)) > kMaxFlattened_rad)
    return overrideError(
        extent.name,
        fmt::format("--frame planar would flatten {:.1f} x {:.1f} degrees, too much of the globe; leave it out",
                    std::fabs(span.x) / kDegree, std::fabs(span.y) / kDegree));
  const double latitude = mapPosition(place, extent.width * 0.5, extent.height * 0.5).y * place.unit;
  const glm::dvec2 scale = metresPerRadian(place.ellipsoid, latitude) * place.unit;
  Georeference flat = place;
  flat.kind = MapKind::kProjected;
  flat.unit = 1;
  for (const size_t i : {0u, 1u, 2u}) flat.transform[i] *= scale.x;
  for (const size_t i : {3u, 4u, 5u}) flat.transform[i] *= scale.y;
  return flat;
}

}  // namespace

Result<Placement> placeRaster(const Georeference& settled, const Extent& extent, const OpenOptions& options) {
  Placement out;
  Georeference place = settled;
  if (options.frame == FrameChoice::kGeographic && place.kind != MapKind::kGeographic)
    return overrideError(extent.name,
                         "--frame geographic cannot be meant for map coordinates (" + place.crs_name +
                             "); convert the file first with gdalwarp -t_srs EPSG:4326, or leave --frame out");
  if (options.frame == FrameChoice::kPlanar && place.kind == MapKind::kGeographic) {
    Result<Georeference> flat = flatten(place, extent);
    if (!flat.ok()) return flat.error();
    place = *flat;
    out.notes.push_back(
        "latitude and longitude were flattened at the middle latitude; the curvature of the ground is lost");
  }
  if (place.kind == MapKind::kGeographic) {
    if (Status s = makeGeographic(place, extent, out); !s.ok()) return s.error();
  } else {
    makePlanar(place, extent, out);
  }
  if (Status s = out.frame.validate(extent.width - 1.0, extent.height - 1.0); !s.ok())
    return Error{s.error().code,
                 extent.name + ": " + s.error().message + "; correct its position with gdal_translate -a_ullr"};
  return out;
}

}  // namespace foreland::terrain
