// Where a lattice position and a height are in metres: the scene frame, the same bits on both ends. The scene frame is
// right-handed with x east (or along the raster's row), y north, z up at its origin; a globe's is the body's own.
//
//   planar      projected input: metres of its map, axes_m per lattice step, scene origin at `anchor`
//   geographic  latitude and longitude on an ellipsoid become a local east-north-up frame at the origin, curvature kept:
//               ECEF in closed form, then a translation and a rotation. Agrees with GeographicLib to 1 mm (test).
//   globe       a cube's lattice (proto/topology/cube.h) on the whole of an ellipsoid (cube_map.h). The scene frame is
//               earth-centred: x towards longitude 0 on the equator, z along the axis to the north. No trigonometry but
//               in latitudes and longitudes. Agrees with GeographicLib to 1e-6 m (test).
//
// Immutable value; any thread; portable to WebAssembly.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "base/result.h"
#include "proto/space/cube_map.h"

namespace foreland::proto {

enum class FrameKind : uint8_t { kPlanar = 0, kGeographic = 1, kGlobe = 2 };

// A position as the raster's owner names it: x eastward, y northward (possibly between samples), height above the zero
// surface.
struct LatticePosition {
  double x = 0;
  double y = 0;
  double height_m = 0;
};

struct Geodetic {
  double latitude_rad = 0;
  double longitude_rad = 0;
  double height_m = 0;
};

struct Frame {
  FrameKind kind = FrameKind::kPlanar;
  double height_quantum_m = 0.1;  // one step of a quantised height

  // Planar. `map_origin` is the scene origin in the map's own metres, for people and files; geometry does not use it.
  glm::dvec2 anchor{0, 0};    // lattice position of the scene origin
  glm::dvec2 axis_x_m{1, 0};  // metres per lattice step along x
  glm::dvec2 axis_y_m{0, 1};  // metres per lattice step along y; axis_x cross axis_y is positive
  glm::dvec2 map_origin_m{0, 0};

  // Geographic: position of lattice (0, 0), step per sample, ellipsoid, and origin of the local frame.
  double latitude0_rad = 0, longitude0_rad = 0;
  double latitude_step_rad = 0, longitude_step_rad = 0;
  double semi_major_m = 6378137.0, flattening = 1 / 298.257223563;
  Geodetic origin;

  // Globe: lattice steps a side of a face, a power of two. The ellipsoid is semi_major_m's; of the origin the height
  // counts alone, which no ground lies below.
  uint32_t face_steps = 0;
  double floor() const { return origin.height_m; }

  // Whether latitude and longitude are known of every position.
  bool isOnEllipsoid() const { return kind != FrameKind::kPlanar; }
  double semiMinor() const { return semi_major_m * (1 - flattening); }
  // On an ellipsoid: the radius of curvature, at least, of level surfaces down to 20 km below the ellipsoid; metres.
  double minRadius() const { return semi_major_m * (1 - flattening) * (1 - flattening) - 20e3; }

  // Finite, non-degenerate, right-handed; latitude within the poles for any lattice position up to (max_x, max_y).
  Status validate(double max_x, double max_y) const;
  bool operator==(const Frame&) const;
};

// A Frame with what its formulas share computed once. Cheap to copy.
class FrameTransform {
 public:
  explicit FrameTransform(const Frame& frame);

  const Frame& frame() const { return frame_; }
  glm::dvec3 toScene(const LatticePosition& position) const;
  glm::dvec3 toScene(const Geodetic& position) const;  // not in planar frames
  // Globes only: of a vertex of the lattice, the same bits as toScene() of its place.
  [[gnu::noinline]] glm::dvec3 vertexOfGlobe(uint32_t x, uint32_t y, double height_m) const {
    const double step = 2.0 / frame_.face_steps;
    uint32_t face = x >> face_log2_;
    if (face > 5) face = 5;
    const double s = (x - (face << face_log2_)) * step - 1, t = y * step - 1;
    return spheroid_.position(cubeVector(face, cubeTangent(s), cubeTangent(t)), height_m);
  }
  const Spheroid& spheroid() const { return spheroid_; }
  // Inverse of toScene to 1e-6 m for points within 10^5 m of the ellipsoid.
  LatticePosition toLattice(const glm::dvec3& scene_m) const;
  Geodetic toGeodetic(const glm::dvec3& scene_m) const;  // not in planar frames
  // The parts of toScene that depend on latitude or on longitude alone; GeographicTables tabulates them.
  struct Row {
    double sin, cos, normal;  // of the latitude; radius of curvature in the prime vertical, metres
  };
  struct Column {
    double sin, cos;  // of the longitude, counted from the origin's meridian
  };
  Row row(double latitude_rad) const;
  Column column(double longitude_rad) const;
  glm::dvec3 fromTables(const Row& row, const Column& column, double height_m) const {
    const glm::dvec3 d = ecef(row, column, height_m) - origin_ecef_;
    return {d.y, cos_lat0_ * d.z - sin_lat0_ * d.x, sin_lat0_ * d.z + cos_lat0_ * d.x};
  }

  // Unit vector away from the zero surface at a point.
  glm::dvec3 upAt(const glm::dvec3& scene_m) const;

 private:
  // Longitudes count from the origin's meridian, so the rotation to east-north-up is one turn about the y axis.
  glm::dvec3 ecef(const Row& lat, const Column& lon, double height_m) const {
    const double ring = (lat.normal + height_m) * lat.cos;
    return {ring * lon.cos, ring * lon.sin, (lat.normal * (1 - e2_) + height_m) * lat.sin};
  }

  Frame frame_;
  uint32_t face_log2_ = 0;
  Spheroid spheroid_;
  double e2_ = 0;
  double sin_lat0_ = 0, cos_lat0_ = 1;  // of the origin
  glm::dvec3 origin_ecef_{0};           // with the origin's meridian turned to longitude 0
};

}  // namespace foreland::proto
