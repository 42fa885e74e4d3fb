#include "proto/space/cube_map.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace foreland::proto {

namespace {

// Which of the vector's components the face's axes are, and their signs.
struct FaceAxes {
  std::array<uint8_t, 3> component;  // of east, of north, of the face's normal
  std::array<double, 3> sign;
};
constexpr std::array<FaceAxes, 6> kAxes{{{{1, 2, 0}, {1, 1, 1}},
                                         {{0, 2, 1}, {-1, 1, 1}},
                                         {{0, 1, 2}, {-1, -1, 1}},
                                         {{2, 1, 0}, {-1, -1, -1}},
                                         {{2, 0, 1}, {-1, 1, -1}},
                                         {{1, 0, 2}, {1, 1, -1}}}};

double squareOf(const glm::dvec3& v) { return (v.x * v.x + v.y * v.y) + v.z * v.z; }

}  // namespace

double cubeCoordinate(double tangent) {
  const double u = std::clamp(tangent, -1.0, 1.0);
  constexpr double kFirst = 0.78539816339744830962, kThird = 0.1615, kFifth = 1 - kFirst - kThird;
  double s = u;
  for (int i = 0; i < 6; ++i) {  // the slope is between 0.78 and 1.54, so it converges from anywhere
    const double s2 = s * s;
    s -= (cubeTangent(s) - u) / (kFirst + s2 * (3 * kThird + s2 * (5 * kFifth)));
  }
  return std::clamp(s, -1.0, 1.0);
}

glm::dvec3 cubeVector(uint32_t face, double u, double v) {
  const FaceAxes& axes = kAxes[face];
  glm::dvec3 vector;
  vector[axes.component[0]] = 0 + axes.sign[0] * u;  // never -0
  vector[axes.component[1]] = 0 + axes.sign[1] * v;
  vector[axes.component[2]] = axes.sign[2];
  return vector;
}

static CubePoint onFace(uint32_t face, const glm::dvec3& v, double depth) {
  const FaceAxes& axes = kAxes[face];
  return {face, cubeCoordinate(axes.sign[0] * v[axes.component[0]] / depth),
          cubeCoordinate(axes.sign[1] * v[axes.component[1]] / depth)};
}

CubePoint cubePoint(const glm::dvec3& v) {
  const glm::dvec3 size(std::fabs(v.x), std::fabs(v.y), std::fabs(v.z));
  const uint32_t axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  return onFace(v[axis] < 0 ? axis + 3 : axis, v, size[axis]);
}

std::optional<CubePoint> cubePointOn(uint32_t face, const glm::dvec3& v) {
  double depth = v[kAxes[face].component[2]] * kAxes[face].sign[2];
  // Beyond a side straight to its great circle.
  for (const int axis : {0, 1})
    if (const double along = std::fabs(v[kAxes[face].component[axis]]); along > depth) depth = 0.5 * (depth + along);
  return depth > 0 ? std::optional(onFace(face, v, depth)) : std::nullopt;
}

Spheroid::Spheroid(double equatorial_m, double polar_m)
    : equatorial_m_(equatorial_m),
      polar_m_(polar_m),
      equatorial2_(equatorial_m * equatorial_m),
      polar2_(polar_m * polar_m) {}

// The point of the surface with the normal n is its gradient's: (A^2 nx, A^2 ny, B^2 nz), scaled to lie on it.
glm::dvec3 Spheroid::position(const glm::dvec3& n, double height_m) const {
  const double to_surface =
      1 / std::sqrt((equatorial2_ * (n.x * n.x) + equatorial2_ * (n.y * n.y)) + polar2_ * (n.z * n.z));
  const double up = height_m / std::sqrt(squareOf(n));
  const double around = equatorial2_ * to_surface + up;
  return {n.x * around, n.y * around, n.z * (polar2_ * to_surface + up)};
}

// Given the height, position() is linear in the normal but for one factor: so a better normal follows from each height.
// The error falls by the eccentricity's square times A / (A + h) a step.
Spheroid::Place Spheroid::place(const glm::dvec3& p) const {
  const double squash = polar2_ / equatorial2_;
  glm::dvec3 n(p.x, p.y, p.z / squash);
  double height = 0;
  for (int i = 0; i < 8; ++i) {
    const double length = std::sqrt(squareOf(n));
    n = length > 0 ? n / length : glm::dvec3(0, 0, 1);
    const double support = std::sqrt(equatorial2_ * (n.x * n.x + n.y * n.y) + polar2_ * (n.z * n.z));
    // Along the normal; the surface's own part of it is the distance of its tangent plane from the centre.
    height = (n.x * p.x + n.y * p.y + n.z * p.z) - support;
    const double around = std::max(equatorial2_ / support + height, 0.05 * equatorial_m_),
                 along = std::max(polar2_ / support + height, 0.05 * polar_m_);
    if (i < 7) n = glm::dvec3(p.x / around, p.y / around, p.z / along);
  }
  return {n, height};
}

}  // namespace foreland::proto
