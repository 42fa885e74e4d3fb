#include "proto/space/frame_grid.h"

namespace foreland::proto {

FrameGrid::FrameGrid(const Frame& frame, uint32_t max_x, uint32_t max_y)
    : transform_(frame), height_quantum_m_(frame.height_quantum_m), tables_(transform_, max_x, max_y) {}

}  // namespace foreland::proto
