// Built-in tours: paths of the camera, planned over a scene's own ground, so that every client, test and benchmark can
// fly the same path.
//   survey  straight, 150 m/s, 300 m above the ground
//   canyon  80 m/s, 60 m above the ground, following the valleys
//   spin    in place, 90 degrees a second
//   orbit   around the highest summit near the middle, looking at it
// On scenes that are too small for these distances, all of them shrink alike; where samples are more than 100 m apart
// they grow alike. Over scenes that are fine in places speed and height are those of their coarse ground, and shrink
// where it is finer (pace.h). Over globes they are others, and there are more (globe_tour.h). The eye stays above the
// ground. Pure functions; any thread. Cost: milliseconds.
#pragma once

#include <string>

#include "base/result.h"
#include "proto/space/path.h"
#include "terrain/store/scene.h"

namespace foreland::server {

// Whether there is a tour of that name over the scene; the Error lists the tours.
Status checkTour(const terrain::Scene& scene, const std::string& name);

// A path that lasts `seconds` (1 to 3600), starts at time 0 and has steps of 100 ms. The Error for an unknown name
// lists the tours.
Result<proto::Path> planTour(const terrain::Scene& scene, const std::string& name, double seconds);

}  // namespace foreland::server
