// The faces of a cube around a body, as docs/THEORY.md defines them: how lattice points lie in space, by vectors and
// trigonometry. The judge's own; the engine has another (proto/space/cube_map.h). Pure; any thread.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "proto/topology/node.h"
#include "terrain/geo/geodesy.h"

namespace foreland::oracle {

class CubeFaces {
 public:
  // Faces of 2^side_log2 steps a side.
  explicit CubeFaces(uint32_t side_log2) : log2_(side_log2), side_(int64_t{1} << side_log2) {}

  int64_t side() const { return side_; }

  // A point of the cube's surface by whole numbers, the cube reaching from -side() to side().
  using Point = glm::vec<3, int64_t>;
  Point pointOn(uint32_t face, glm::vec<2, int64_t> place) const;
  // Of the vertex with a name.
  Point pointOf(proto::NodeId name) const;

  // The name of a vertex: its place on the one face whose square holds it without its north and east sides; two corners
  // are named by faces 0 and 5, on the first's north and the other's east side.
  proto::NodeId nameOf(const Point& point) const;

  // The face that holds three points; nothing if they are not on one.
  static std::optional<uint32_t> faceOf(const Point& a, const Point& b, const Point& c, int64_t side);
  // Where a point lies on a face's square, which holds it.
  glm::vec<2, int64_t> placeOn(uint32_t face, const Point& point) const;

  // Latitude and longitude of a place on a face's square, by the angles of its direction.
  proto::Geodetic geodetic(uint32_t face, glm::dvec2 place) const;
  // The other way: a face that a direction, of any length but 0, meets, and where; to 1e-9 steps.
  struct FacePlace {
    uint32_t face = 0;
    glm::dvec2 place{0};
  };
  FacePlace placeOf(const glm::dvec3& direction) const;

 private:
  uint32_t log2_;
  int64_t side_;
};

// Whether a straight line from the eye to a point passes through an ellipsoid, on the way to the point.
bool isBehind(const terrain::Ellipsoid& ellipsoid, const glm::dvec3& eye, const glm::dvec3& point);

}  // namespace foreland::oracle
