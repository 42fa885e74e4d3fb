// For whom a section is computed, and how exactly. Value type; any thread; portable to WebAssembly.
#pragma once

#include "proto/space/pose.h"

namespace foreland::proto {

struct View {
  Pose pose;
  Lens lens;
  double tau_px = 1;
  double region_radius_m = 0;   // the eye stays this near to pose.eye while the section is shown
  double region_angle_rad = 0;  // and turns by no more than this
};

}  // namespace foreland::proto
