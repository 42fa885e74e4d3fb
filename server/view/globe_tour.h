// The tours of view/tour.h over a globe: planned by direction and height apart, over what is special about a cube that
// is blown up to a planet. Distances are shares of its radius.
//
//   survey  descends from six radii above the highest ground that coarse levels know, until it is close
//   canyon  flies low along the antimeridian, over the north pole and on
//   spin    turns around over a corner of the cube
//   orbit   goes round once over both poles and four corners of the cube
#pragma once

#include <string>

#include "proto/space/path.h"
#include "terrain/store/scene.h"

namespace foreland::server {

// `name` is one of the above; so many poses, `step` apart.
proto::Path planGlobeTour(const terrain::Scene& scene, const std::string& name, size_t poses, Duration step);

}  // namespace foreland::server
