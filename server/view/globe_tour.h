// The tours of view/tour.h over a globe, planned by direction and height apart: over what is special about a cube that
// is blown up to a planet. Distances are shares of its radius.
//
//   survey        descends from six radii above the highest ground that coarse levels know, until it is close
//   canyon        flies low along the antimeridian, over the north pole and on
//   spin          turns around over a corner of the cube
//   orbit         goes round once over both poles and four corners of the cube
//   descent       falls from 40,000 km above the earth to 60 m above the highest ground of its finest samples, evenly
//                 by the logarithm of the height; descent:LAT,LON goes to a place, in degrees
//   pole          low from one side of the north pole to the other
//   antimeridian  from the south to the north, along longitude 180
//   corner        low over a corner of the cube, from an edge to the face beyond
//   equator       around the body, along the equator
//
// On the last five the camera goes a fifth of its height a second, or less: what keyframes 0.2 s apart have to allow
// for is a tenth of the height at most, for flights of a minute and longer.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string>

#include "proto/space/path.h"
#include "terrain/store/scene.h"

namespace foreland::server {

// Where a camera is over a globe: along a normal, so high above the ground.
struct Station {
  glm::dvec3 direction;  // of length 1
  double above_m;        // positive
};

// From a (share 0) to b (1): the logarithm of the height goes evenly, and the direction along the great circle as the
// height does, so that the camera nears its goal on a straight line, and never passes through the body; between equal
// heights evenly. Directions are not opposite.
Station between(const Station& a, const Station& b, double share);

// Whether it is one of the above. Nothing if it is none of these tours; else an Error where a place is no place.
std::optional<Status> checkGlobeTour(const std::string& name);

// `name` is one of the above; so many poses, `step` apart.
proto::Path planGlobeTour(const terrain::Scene& scene, const std::string& name, size_t poses, Duration step);

}  // namespace foreland::server
