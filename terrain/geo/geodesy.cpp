#include "terrain/geo/geodesy.h"

#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/LocalCartesian.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "base/check.h"

namespace foreland::terrain {

namespace {

constexpr double kDegree = std::numbers::pi / 180;

GeographicLib::LocalCartesian localFrame(const proto::Frame& frame) {
  CHECK_TRUE(frame.kind == proto::FrameKind::kGeographic);
  const GeographicLib::Geocentric earth(frame.semi_major_m, frame.flattening);
  return {frame.origin.latitude_rad / kDegree, frame.origin.longitude_rad / kDegree, frame.origin.height_m, earth};
}

}  // namespace

glm::dvec3 referenceToScene(const proto::Frame& frame, const proto::Geodetic& place) {
  glm::dvec3 p;
  localFrame(frame).Forward(place.latitude_rad / kDegree, place.longitude_rad / kDegree, place.height_m, p.x, p.y, p.z);
  return p;
}

proto::Geodetic referenceToGeodetic(const proto::Frame& frame, const glm::dvec3& scene_m) {
  double latitude = 0, longitude = 0, height_m = 0;
  localFrame(frame).Reverse(scene_m.x, scene_m.y, scene_m.z, latitude, longitude, height_m);
  return {latitude * kDegree, longitude * kDegree, height_m};
}

glm::dvec3 referencePosition(const Ellipsoid& ellipsoid, const proto::Geodetic& place) {
  glm::dvec3 p;
  GeographicLib::Geocentric(ellipsoid.semi_major_m, ellipsoid.flattening)
      .Forward(place.latitude_rad / kDegree, place.longitude_rad / kDegree, place.height_m, p.x, p.y, p.z);
  return p;
}

proto::Geodetic referencePlace(const Ellipsoid& ellipsoid, const glm::dvec3& p) {
  double latitude = 0, longitude = 0, height_m = 0;
  GeographicLib::Geocentric(ellipsoid.semi_major_m, ellipsoid.flattening)
      .Reverse(p.x, p.y, p.z, latitude, longitude, height_m);
  return {latitude * kDegree, longitude * kDegree, height_m};
}

glm::dvec2 metresPerRadian(const Ellipsoid& ellipsoid, double latitude_rad) {
  const double e2 = ellipsoid.flattening * (2 - ellipsoid.flattening), s = std::sin(latitude_rad);
  const double w2 = 1 - e2 * s * s, normal = ellipsoid.semi_major_m / std::sqrt(w2);
  return {normal * std::cos(latitude_rad), normal * (1 - e2) / w2};
}

glm::dvec2 sampleSpacing(const proto::Frame& frame, uint32_t width, uint32_t height) {
  if (frame.kind == proto::FrameKind::kPlanar) return {glm::length(frame.axis_x_m), glm::length(frame.axis_y_m)};
  if (frame.kind == proto::FrameKind::kGlobe)  // a quarter of the equator is as long as a face, whatever its cells
    return glm::dvec2(0.5 * std::numbers::pi * frame.semi_major_m / frame.face_steps);
  (void)width;  // the same along a parallel
  const double latitude = frame.latitude0_rad + 0.5 * height * frame.latitude_step_rad;
  const glm::dvec2 metres = metresPerRadian({frame.semi_major_m, frame.flattening}, latitude);
  return {metres.x * frame.longitude_step_rad, metres.y * frame.latitude_step_rad};
}

}  // namespace foreland::terrain
