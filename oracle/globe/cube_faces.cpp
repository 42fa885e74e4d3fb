#include "oracle/globe/cube_faces.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace foreland::oracle {

namespace {

using Point = CubeFaces::Point;

struct Face {
  Point out, east, north;
};
constexpr Face kFaces[6] = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},   {{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}},
                            {{0, 0, 1}, {-1, 0, 0}, {0, -1, 0}}, {{-1, 0, 0}, {0, 0, -1}, {0, -1, 0}},
                            {{0, -1, 0}, {0, 0, -1}, {1, 0, 0}}, {{0, 0, -1}, {0, 1, 0}, {1, 0, 0}}};

int64_t along(const Point& p, const Point& axis) { return p.x * axis.x + p.y * axis.y + p.z * axis.z; }

// The quintic of a square's coordinate.
double tangentOf(double s) {
  const double a = std::acos(-1.0) / 4, b = 0.1615;
  return a * s + b * std::pow(s, 3) + (1 - a - b) * std::pow(s, 5);
}

// The coordinate of a tangent, by Newton's steps from that of equal angles; the quintic rises everywhere.
double coordinateOf(double tangent) {
  const double a = std::acos(-1.0) / 4, b = 0.1615, c = 1 - a - b;
  double s = std::atan(tangent) / a;
  for (int i = 0; i < 5; ++i) {
    const double s2 = s * s;
    s -= (s * (a + s2 * (b + s2 * c)) - tangent) / (a + s2 * (3 * b + s2 * 5 * c));
  }
  return s;
}

double along(const glm::dvec3& p, const Point& axis) { return glm::dot(p, glm::dvec3(axis)); }

}  // namespace

Point CubeFaces::pointOn(uint32_t face, glm::vec<2, int64_t> place) const {
  const Face& f = kFaces[face];
  return f.out * side_ + f.east * (2 * place.x - side_) + f.north * (2 * place.y - side_);
}

Point CubeFaces::pointOf(proto::NodeId name) const {
  const uint32_t face = std::min(name.x() >> log2_, 5u);
  return pointOn(face, {int64_t{name.x()} - (int64_t{face} << log2_), name.y()});
}

proto::NodeId CubeFaces::nameOf(const Point& point) const {
  const auto name = [&](uint32_t face, const glm::vec<2, int64_t>& at) {
    return proto::NodeId::at(static_cast<uint32_t>((int64_t{face} << log2_) + at.x), static_cast<uint32_t>(at.y));
  };
  for (uint32_t face = 0; face < 6; ++face) {
    if (along(point, kFaces[face].out) != side_) continue;
    if (const auto at = placeOn(face, point); at.x < side_ && at.y < side_) return name(face, at);
  }
  return along(point, kFaces[0].out) == side_ ? name(0, {0, side_}) : name(5, {side_, 0});
}

std::optional<uint32_t> CubeFaces::faceOf(const Point& a, const Point& b, const Point& c, int64_t side) {
  for (uint32_t face = 0; face < 6; ++face)
    if (along(a, kFaces[face].out) == side && along(b, kFaces[face].out) == side && along(c, kFaces[face].out) == side)
      return face;
  return std::nullopt;
}

glm::vec<2, int64_t> CubeFaces::placeOn(uint32_t face, const Point& point) const {
  return {(along(point, kFaces[face].east) + side_) / 2, (along(point, kFaces[face].north) + side_) / 2};
}

proto::Geodetic CubeFaces::geodetic(uint32_t face, glm::dvec2 place) const {
  const Face& f = kFaces[face];
  const double s = static_cast<double>(side_), u = tangentOf(2 * place.x / s - 1), v = tangentOf(2 * place.y / s - 1);
  const glm::dvec3 d = glm::dvec3(f.out) + u * glm::dvec3(f.east) + v * glm::dvec3(f.north);
  return {std::atan2(d.z, std::hypot(d.x, d.y)), std::atan2(d.y, d.x), 0};
}

CubeFaces::FacePlace CubeFaces::placeOf(const glm::dvec3& direction) const {
  uint32_t face = 0;
  for (uint32_t other = 1; other < 6; ++other)
    if (along(direction, kFaces[other].out) > along(direction, kFaces[face].out)) face = other;
  const double out = along(direction, kFaces[face].out);
  const auto coordinate = [&](const Point& axis) {
    return std::clamp((coordinateOf(along(direction, axis) / out) + 1) / 2, 0.0, 1.0) * static_cast<double>(side_);
  };
  return {face, {coordinate(kFaces[face].east), coordinate(kFaces[face].north)}};
}

bool isBehind(const terrain::Ellipsoid& ellipsoid, const glm::dvec3& eye, const glm::dvec3& point) {
  const glm::dvec3 squeeze(1 / ellipsoid.semi_major_m, 1 / ellipsoid.semi_major_m,
                           1 / (ellipsoid.semi_major_m * (1 - ellipsoid.flattening)));
  // The nearest point to the centre of the unit ball, on the segment.
  const glm::dvec3 e = eye * squeeze, way = point * squeeze - e;
  const double t = std::clamp(-glm::dot(e, way) / glm::dot(way, way), 0.0, 1.0);
  return glm::length(e + t * way) < 1;
}

}  // namespace foreland::oracle
