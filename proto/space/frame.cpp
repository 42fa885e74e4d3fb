#include "proto/space/frame.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>

#include "proto/space/trig.h"

namespace foreland::proto {

namespace {

constexpr double kHalfPi = 1.57079632679489661923;

bool allFinite(std::initializer_list<double> values) {
  for (double v : values)
    if (!std::isfinite(v) || std::fabs(v) > 1e12) return false;
  return true;
}

Error malformed(std::string_view what) { return {ErrorCode::kMalformed, std::string("frame: ").append(what)}; }

}  // namespace

bool Frame::operator==(const Frame& o) const {
  return kind == o.kind && height_quantum_m == o.height_quantum_m && anchor == o.anchor && axis_x_m == o.axis_x_m &&
         axis_y_m == o.axis_y_m && map_origin_m == o.map_origin_m && latitude0_rad == o.latitude0_rad &&
         longitude0_rad == o.longitude0_rad && latitude_step_rad == o.latitude_step_rad &&
         longitude_step_rad == o.longitude_step_rad && semi_major_m == o.semi_major_m && flattening == o.flattening &&
         origin.latitude_rad == o.origin.latitude_rad && origin.longitude_rad == o.origin.longitude_rad &&
         origin.height_m == o.origin.height_m && face_steps == o.face_steps;
}

Status Frame::validate(double max_x, double max_y) const {
  if (!allFinite({height_quantum_m, anchor.x, anchor.y, axis_x_m.x, axis_x_m.y, axis_y_m.x, axis_y_m.y, map_origin_m.x,
                  map_origin_m.y, latitude0_rad, longitude0_rad, latitude_step_rad, longitude_step_rad, semi_major_m,
                  flattening, origin.latitude_rad, origin.longitude_rad, origin.height_m}))
    return malformed("a number is not finite or beyond 10^12");
  if (!(height_quantum_m > 0)) return malformed("the height step is not positive");
  if (kind == FrameKind::kPlanar) {
    if (!(axis_x_m.x * axis_y_m.y - axis_x_m.y * axis_y_m.x > 0)) return malformed("the axes are not right-handed");
    return {};
  }
  if (!(semi_major_m > 0) || flattening < 0 || flattening >= 1) return malformed("not an ellipsoid");
  if (kind == FrameKind::kGlobe) {
    if (flattening > 0.1 || semi_major_m < 1e3 || semi_major_m > 1e9) return malformed("not a planet's ellipsoid");
    if (!std::has_single_bit(face_steps) || max_x != 6.0 * face_steps || max_y != face_steps)
      return malformed("the faces do not fit the lattice");
    if (!(std::fabs(origin.height_m) < 0.1 * semi_major_m))
      return malformed("the lowest ground is not near the surface");
    return {};
  }
  if (kind != FrameKind::kGeographic) return malformed("unknown kind");
  const double last_latitude = latitude0_rad + max_y * latitude_step_rad;
  if (!(latitude_step_rad > 0) || !(longitude_step_rad > 0))
    return malformed("steps of latitude and longitude must be positive");
  // Root squares may reach past the data, so a little past the pole is allowed; the data itself never is.
  if (latitude0_rad < -kHalfPi - 1e-9 || last_latitude > 2 * kHalfPi || std::fabs(longitude0_rad) > 8 * kHalfPi ||
      longitude0_rad + max_x * longitude_step_rad > 8 * kHalfPi)
    return malformed("latitude or longitude outside the globe");
  if (std::fabs(origin.latitude_rad) > 2 * kHalfPi || std::fabs(origin.longitude_rad) > 8 * kHalfPi)
    return malformed("the origin lies outside the globe");
  return {};
}

FrameTransform::FrameTransform(const Frame& frame)
    : frame_(frame),
      face_log2_(static_cast<uint32_t>(std::countr_zero(frame.face_steps | 1u << 31))),
      spheroid_(frame.semi_major_m, frame.semiMinor()) {
  if (frame_.kind != FrameKind::kGeographic) return;
  e2_ = frame_.flattening * (2 - frame_.flattening);
  const SinCos lat = sinCos(frame_.origin.latitude_rad);
  sin_lat0_ = lat.sin;
  cos_lat0_ = lat.cos;
  origin_ecef_ = ecef(row(frame_.origin.latitude_rad), column(frame_.origin.longitude_rad), frame_.origin.height_m);
}

FrameTransform::Row FrameTransform::row(double latitude_rad) const {
  const SinCos lat = sinCos(latitude_rad);
  return {lat.sin, lat.cos, frame_.semi_major_m / std::sqrt(1 - e2_ * lat.sin * lat.sin)};
}

FrameTransform::Column FrameTransform::column(double longitude_rad) const {
  const SinCos lon = sinCos(longitude_rad - frame_.origin.longitude_rad);
  return {lon.sin, lon.cos};
}

glm::dvec3 FrameTransform::toScene(const Geodetic& position) const {
  if (frame_.kind == FrameKind::kGlobe) {
    const SinCos lat = sinCos(position.latitude_rad), lon = sinCos(position.longitude_rad);
    return spheroid_.position({lat.cos * lon.cos, lat.cos * lon.sin, lat.sin}, position.height_m);
  }
  return fromTables(row(position.latitude_rad), column(position.longitude_rad), position.height_m);
}

glm::dvec3 FrameTransform::toScene(const LatticePosition& position) const {
  if (frame_.kind == FrameKind::kGeographic)
    return toScene(Geodetic{frame_.latitude0_rad + position.y * frame_.latitude_step_rad,
                            frame_.longitude0_rad + position.x * frame_.longitude_step_rad, position.height_m});
  if (frame_.kind == FrameKind::kGlobe) {
    const double steps = frame_.face_steps, face = std::clamp(std::floor(position.x / steps), 0.0, 5.0);
    const double s = (position.x - face * steps) * (2 / steps) - 1, t = position.y * (2 / steps) - 1;
    return spheroid_.position(cubeVector({static_cast<uint32_t>(face), s, t}), position.height_m);
  }
  const double dx = position.x - frame_.anchor.x, dy = position.y - frame_.anchor.y;
  return {dx * frame_.axis_x_m.x + dy * frame_.axis_y_m.x, dx * frame_.axis_x_m.y + dy * frame_.axis_y_m.y,
          position.height_m};
}

Geodetic FrameTransform::toGeodetic(const glm::dvec3& p) const {
  if (frame_.kind == FrameKind::kGlobe) {
    const auto [n, height_m] = spheroid_.place(p);
    return {arcTan2(n.z, std::sqrt(n.x * n.x + n.y * n.y)), arcTan2(n.y, n.x), height_m};
  }
  const double x = origin_ecef_.x - sin_lat0_ * p.y + cos_lat0_ * p.z;
  const double y = origin_ecef_.y + p.x;
  const double z = origin_ecef_.z + cos_lat0_ * p.y + sin_lat0_ * p.z;
  const double ring = std::sqrt(x * x + y * y);
  double latitude = arcTan2(z, ring * (1 - e2_));
  double height = 0;
  for (int i = 0; i < 6; ++i) {  // contracts by e2 * N / (N + h) a step: six give far below a micrometre
    const SinCos s = sinCos(latitude);
    const double normal = frame_.semi_major_m / std::sqrt(1 - e2_ * s.sin * s.sin);
    height = ring * s.cos + z * s.sin - frame_.semi_major_m * std::sqrt(1 - e2_ * s.sin * s.sin);
    latitude = arcTan2(z, ring * (1 - e2_ * normal / (normal + height)));
  }
  double longitude = arcTan2(y, x) + frame_.origin.longitude_rad;
  return {latitude, longitude, height};
}

LatticePosition FrameTransform::toLattice(const glm::dvec3& p) const {
  if (frame_.kind == FrameKind::kGeographic) {
    const Geodetic g = toGeodetic(p);
    return {(g.longitude_rad - frame_.longitude0_rad) / frame_.longitude_step_rad,
            (g.latitude_rad - frame_.latitude0_rad) / frame_.latitude_step_rad, g.height_m};
  }
  if (frame_.kind == FrameKind::kGlobe) {
    const auto [n, height_m] = spheroid_.place(p);
    const CubePoint at = cubePoint(n);
    const double half = 0.5 * frame_.face_steps, end = (2 * at.face + 2) * half;
    double x = (2 * at.face + at.s + 1) * half;
    if (x >= end && at.face % 2 == 1) x = end * (1 - 0x1p-52);  // the east side's own name is elsewhere (cube.h)
    return {x, (at.t + 1) * half, height_m};
  }
  const glm::dvec2 a = frame_.axis_x_m, b = frame_.axis_y_m;
  const double determinant = a.x * b.y - a.y * b.x;
  return {frame_.anchor.x + (p.x * b.y - p.y * b.x) / determinant,
          frame_.anchor.y + (p.y * a.x - p.x * a.y) / determinant, p.z};
}

glm::dvec3 FrameTransform::upAt(const glm::dvec3& p) const {
  if (frame_.kind == FrameKind::kPlanar) return {0, 0, 1};
  if (frame_.kind == FrameKind::kGlobe) return spheroid_.place(p).normal;
  const Geodetic g = toGeodetic(p);
  return glm::normalize(toScene(Geodetic{g.latitude_rad, g.longitude_rad, g.height_m + 1000}) - p);
}

}  // namespace foreland::proto
