// The region of a keyframe: where the camera will be while its section is shown, from the keyframe before it to the one
// after it. The refiner keeps the tolerance for every pose in the region (THEORY section 3), so the region is a bound.
// Pure functions; any thread.
#pragma once

#include "server/view/expected_motion.h"

namespace foreland::server {

// All poses whose eye is within `radius_m` of a given pose's eye and whose orientation is within `angle_rad` of its.
struct Region {
  double radius_m = 0;
  double angle_rad = 0;
};

// What a keyframe's region adds up: the expected motion around its pose, how much predictions were off by of late, and
// what is always allowed for. Only errors may be reduced (RegionShare).
struct RegionParts {
  Region motion, error, rest;

  // What a camera needs that is where it is expected.
  Region withoutErrors() const { return {motion.radius_m + rest.radius_m, motion.angle_rad + rest.angle_rad}; }
};

// A region around `centre` that holds motion.at(t) for all t in [begin, end], up to rounding of less than a micrometre.
// It is larger than the smallest one by at most the allowance that region.cpp describes: a twentieth of the longest
// step of 20 ms, or more where the eye accelerates hard. Cost: one pose each 20 ms (at most 200), and one for each
// corner of the motion.
Region regionOf(const proto::Pose& centre, const ExpectedMotion& motion, Time begin, Time end);

}  // namespace foreland::server
