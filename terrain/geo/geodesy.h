// Geodesy through GeographicLib: the reference that the closed forms of proto/space/frame.h are tested against, and the
// few lengths that building a scene needs. The only folder that includes GeographicLib. Pure functions; any thread;
// nothing throws.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "base/result.h"
#include "proto/space/frame.h"

namespace foreland::terrain {

struct Ellipsoid {
  double semi_major_m = 6378137.0;  // WGS84
  double flattening = 1 / 298.257223563;
};

// Scene position of a geodetic position in a geographic frame, and back, by GeographicLib's LocalCartesian. Longitude
// in
// (-pi, pi].
glm::dvec3 referenceToScene(const proto::Frame& frame, const proto::Geodetic& place);
proto::Geodetic referenceToGeodetic(const proto::Frame& frame, const glm::dvec3& scene_m);

// Earth-centred position of a geodetic position, and back, by GeographicLib's Geocentric.
glm::dvec3 referencePosition(const Ellipsoid& ellipsoid, const proto::Geodetic& place);
proto::Geodetic referencePlace(const Ellipsoid& ellipsoid, const glm::dvec3& position_m);

// Metres per radian of longitude (x) and of latitude (y) at a latitude, height 0.
glm::dvec2 metresPerRadian(const Ellipsoid& ellipsoid, double latitude_rad);

// Metres between neighbouring samples along x and y in the middle of a raster of width x height samples.
glm::dvec2 sampleSpacing(const proto::Frame& frame, uint32_t width, uint32_t height);

}  // namespace foreland::terrain
