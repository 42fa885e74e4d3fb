// Built-in tours: paths of the camera planned over a scene's own ground, so that every client, test and benchmark can
// fly the same.
//   survey  straight, 150 m/s, 300 m above the ground
//   canyon  80 m/s, 60 m above the ground, following the valleys
//   spin    in place, 90 degrees a second
//   orbit   around the highest summit near the middle, looking at it
// Scenes too small for those distances get them scaled down. Pure functions; any thread; milliseconds.
#pragma once

#include <string>

#include "base/result.h"
#include "proto/space/path.h"
#include "terrain/store/scene.h"

namespace foreland::server {

// A path of `seconds` that starts at time 0, with steps of 100 ms. An Error names the tours there are.
Result<proto::Path> planTour(const terrain::Scene& scene, const std::string& name, double seconds);

}  // namespace foreland::server
