// A rough plain with a steep ridge across it, and a flight towards the ridge that never sees what lies behind it.
#pragma once

#include <cmath>

#include "lab/sections/flight_views.h"
#include "server/section/hierarchy.h"
#include "tests/support/scene.h"

namespace foreland::test {

// 257 x 257 samples, 10 m apart; the ridge runs along x = 100 and is 400 m high.
inline double ridgeHeight(uint32_t x, uint32_t y) {
  const double ridge = std::max(0.0, 400 - 0.8 * 10 * std::fabs(x - 100.0));
  return ridge + 12 * std::sin(0.9 * x) * std::cos(0.7 * y) + 6 * std::sin(2.1 * x + 1.3 * y);
}
inline std::shared_ptr<const terrain::Scene> ridgeScene() { return makeScene(257, 257, ridgeHeight); }

// Along x from sample 5, 60 m up and looking ahead, 20 m/s.
inline proto::Path ridgeFlight(const server::Hierarchy& hierarchy, double seconds) {
  proto::Path path;
  for (int i = 0; i <= 10 * seconds + 1; ++i) {
    proto::Pose pose;
    pose.eye = hierarchy.frame().transform().toScene(proto::LatticePosition{5 + 0.2 * i, 128, 60});
    pose.orientation = proto::lookAlong({1, 0, 0}, {0, 0, 1});
    path.poses.push_back(pose);
  }
  return path;
}

inline lab::FlightOptions ridgeOptions(double seconds) {
  return {.lens = {1.0, 320, 180}, .tau_px = 0.5, .seconds = seconds};
}

}  // namespace foreland::test
