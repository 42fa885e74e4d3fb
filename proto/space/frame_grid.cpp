#include "proto/space/frame_grid.h"

namespace foreland::proto {

FrameGrid::FrameGrid(const Frame& frame, uint32_t max_x, uint32_t max_y)
    : transform_(frame), step_m_(frame.height_quantum_m) {
  if (frame.kind != FrameKind::kGeographic) return;
  rows_.reserve(max_y + 1);
  columns_.reserve(max_x + 1);
  for (uint32_t y = 0; y <= max_y; ++y)
    rows_.push_back(transform_.row(frame.latitude0_rad + y * frame.latitude_step_rad));
  for (uint32_t x = 0; x <= max_x; ++x)
    columns_.push_back(transform_.column(frame.longitude0_rad + x * frame.longitude_step_rad));
}

}  // namespace foreland::proto
