// The lattice of one degree square at 3", as SRTM tiles are.
#pragma once

#include "proto/space/frame.h"
#include "proto/topology/grid.h"

namespace foreland::client {

constexpr double kDeg = 0.017453292519943295;

inline proto::Frame alpineFrame() {
  return {.kind = proto::FrameKind::kGeographic,
          .latitude0_rad = 46 * kDeg,
          .longitude0_rad = 8 * kDeg,
          .latitude_step_rad = kDeg / 1200,
          .longitude_step_rad = kDeg / 1200,
          .origin = {46.5 * kDeg, 8.5 * kDeg, 0}};
}
constexpr proto::GridShape kShape{.roots_x = 5, .roots_y = 5, .root_log2 = 8, .samples_x = 1201, .samples_y = 1201};

}  // namespace foreland::client
