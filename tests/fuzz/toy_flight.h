// What the deltas' fuzzer and the recorder of its corpus agree on: the terrain, the views, and how an input says
// deltas. Input: a byte that says where the camera goes (and whether it begins with a section that the client
// presented: its lowest bit), then up to kToySteps deltas, each with its size before it in two bytes, little-endian.
#pragma once

#include "proto/pose.h"
#include "tests/support/toy_terrain.h"

namespace foreland::test {

inline constexpr int kToySteps = 4;

inline const ToyTerrain& toyFlightTerrain() {
  static const ToyTerrain terrain({2, 2, 4, 33, 30}, 1);
  return terrain;
}

inline proto::View toyFlightView(uint8_t how, int step) {
  proto::View view;
  view.pose = {{160.0 + 7 * step, 100.0 + how, 250.0 + 3 * how}, proto::lookAlong({0.5, 0.3, -0.8}, {0, 0, 1})};
  view.tau_px = static_cast<float>(1 + (how >> 6));
  view.ball_m = static_cast<float>(step);
  return view;
}

// The section that a flight begins with: empty, or what the client presents.
inline proto::Section toyFlightBegin(uint8_t how) {
  return how & 1 ? toyFlightTerrain().refine(toyFlightView(how, 2)) : proto::Section();
}

}  // namespace foreland::test
