#include "proto/space/geographic_tables.h"

namespace foreland::proto {

GeographicTables::GeographicTables(const FrameTransform& transform, uint32_t max_x, uint32_t max_y) {
  const Frame& frame = transform.frame();
  if (frame.kind != FrameKind::kGeographic) return;
  rows.reserve(max_y + 1);
  columns.reserve(max_x + 1);
  for (uint32_t y = 0; y <= max_y; ++y)
    rows.push_back(transform.row(frame.latitude0_rad + y * frame.latitude_step_rad));
  for (uint32_t x = 0; x <= max_x; ++x)
    columns.push_back(transform.column(frame.longitude0_rad + x * frame.longitude_step_rad));
}

}  // namespace foreland::proto
