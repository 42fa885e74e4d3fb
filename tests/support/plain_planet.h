// A planet as its finest triangles, which are found by the judge's own faces (oracle/globe/cube_faces.h) and stand
// where GeographicLib says.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

#include "oracle/globe/cube_faces.h"
#include "terrain/geo/geodesy.h"
#include "terrain/store/scene.h"
#include "tests/support/sight_reference.h"

namespace foreland::test {

// Of a point from a triangle: from its plane within, from its edges beside it.
inline double distanceTo(const Corners& t, const glm::dvec3& p) {
  const glm::dvec3 normal = glm::normalize(glm::cross(t[1] - t[0], t[2] - t[0]));
  double least = std::numeric_limits<double>::infinity();
  bool is_within = true;
  for (size_t i = 0; i < 3; ++i) {
    const glm::dvec3 edge = t[(i + 1) % 3] - t[i], to = p - t[i];
    is_within = is_within && glm::dot(glm::cross(edge, to), normal) >= 0;
    const double share = std::clamp(glm::dot(to, edge) / glm::dot(edge, edge), 0.0, 1.0);
    least = std::min(least, glm::length(to - share * edge));
  }
  return is_within ? std::min(least, std::fabs(glm::dot(p - t[0], normal))) : least;
}

class PlainPlanet {
 public:
  explicit PlainPlanet(const terrain::Scene& scene) : scene_(scene), cube_(scene.grid().shape().root_log2) {
    const int64_t side = cube_.side();
    for (uint32_t face = 0; face < 6; ++face) {
      const Place middle{side / 2, side / 2}, corners[4] = {{0, 0}, {side, 0}, {side, side}, {0, side}};
      for (int i = 0; i < 4; ++i) split(face, {corners[i], corners[(i + 1) % 4], middle});
    }
  }

  template <class Visit>
  void forAll(const Visit& visit) const {
    for (const Corners& t : triangles_) visit(t);
  }
  const std::vector<Corners>& triangles() const { return triangles_; }
  bool isThere(uint32_t face, const glm::vec<2, int64_t>& place) const { return isThere(cube_.pointOn(face, place)); }
  // Of a place on a face, at a height above the ellipsoid.
  glm::dvec3 at(uint32_t face, const glm::dvec2& place, double height_m) const {
    proto::Geodetic at = cube_.geodetic(face, place);
    at.height_m = height_m;
    return terrain::referencePosition({scene_.frame().semi_major_m, scene_.frame().flattening}, at);
  }
  double heightMetres(uint32_t face, const glm::vec<2, int64_t>& place) const {
    return scene_.height(cube_.nameOf(cube_.pointOn(face, place))) * scene_.frame().height_quantum_m;
  }

 private:
  using Place = glm::vec<2, int64_t>;

  bool isThere(const oracle::CubeFaces::Point& point) const {
    const proto::NodeId name = cube_.nameOf(point);
    return scene_.grid().isBase(name) || scene_.pages().hasPage(scene_.grid().slot(name));
  }
  void split(uint32_t face, const std::array<Place, 3>& t) {
    const Place twice = t[0] + t[1], half = twice / int64_t{2};
    if (twice.x % 2 == 0 && twice.y % 2 == 0 && isThere(cube_.pointOn(face, half))) {
      split(face, {t[1], t[2], half});
      split(face, {t[2], t[0], half});
      return;
    }
    Corners corners;
    for (size_t i = 0; i < 3; ++i) corners[i] = at(face, glm::dvec2(t[i]), heightMetres(face, t[i]));
    triangles_.push_back(corners);
  }

  const terrain::Scene& scene_;
  oracle::CubeFaces cube_;
  std::vector<Corners> triangles_;
};

}  // namespace foreland::test
