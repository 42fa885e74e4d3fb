// From the squares of a cube to directions, and from directions to positions on and above a spheroid: how a globe's
// lattice lies in space (decision 0062). Sums, products, quotients and square roots only, so native code and
// WebAssembly agree to the bit; and a point of the cube's edges or corners gets the same bits from each face that has
// it. Axes are the body's: x towards longitude 0 on the equator, z towards the north pole. Pure; any thread; O(1).
//
// Face f looks along +x, +y, +z, -x, -y, -z for f = 0 to 5. The square's coordinates run from -1 to 1, s east, t north.
// A quintic, odd and increasing, evens out the areas of cells: the largest is 1.47 times the smallest.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>

namespace foreland::proto {

// A point on the square of a face of the cube.
struct CubePoint {
  uint32_t face = 0;
  double s = 0, t = 0;
};

// The tangent of a square's coordinate, and its inverse, to the last bits: -1, 0 and 1 are themselves.
inline double cubeTangent(double s) {
  constexpr double kFirst = 0.78539816339744830962, kThird = 0.1615, kFifth = 1 - kFirst - kThird;
  static_assert(kFirst + (kThird + kFifth) == 1);
  const double s2 = s * s;
  return s * (kFirst + s2 * (kThird + s2 * kFifth));
}
double cubeCoordinate(double tangent);

// A vector of one of the cube's surface points: not of length 1. `u` and `v` are tangents.
glm::dvec3 cubeVector(uint32_t face, double u, double v);
inline glm::dvec3 cubeVector(const CubePoint& p) { return cubeVector(p.face, cubeTangent(p.s), cubeTangent(p.t)); }
// Of a vector of any length but 0; on edges and corners the lowest axis's face.
CubePoint cubePoint(const glm::dvec3& vector);

// Of a face the point that is nearest to a vector beyond one of its sides, and about the nearest beyond a corner.
// Nothing of vectors that are far away.
std::optional<CubePoint> cubePointOn(uint32_t face, const glm::dvec3& vector);

// A body of revolution.
class Spheroid {
 public:
  Spheroid(double equatorial_m, double polar_m);

  // At a geodetic height along the normal. `normal` may have any length but 0.
  glm::dvec3 position(const glm::dvec3& normal, double height_m) const;

  struct Place {
    glm::dvec3 normal;  // of length 1
    double height_m;
  };
  // Inverse of position() to 1e-6 m within 10^5 m of the surface and to 1e-12 of the distance above; for points nearer
  // to the centre than a tenth of the axes some place.
  Place place(const glm::dvec3& position_m) const;

  double equatorial() const { return equatorial_m_; }
  double polar() const { return polar_m_; }

 private:
  double equatorial_m_, polar_m_, equatorial2_, polar2_;
};

}  // namespace foreland::proto
