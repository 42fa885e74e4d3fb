#include "client/area.h"

#include <algorithm>
#include <cmath>

namespace foreland::client {
namespace {

// Of `samples` along an axis: the areas that they lie in. Those on the far side are in the last one.
uint32_t areasOf(uint32_t samples) { return std::max(1u, (samples - 2 + (1u << kAreaLog2)) >> kAreaLog2); }

// `position` is finite.
uint32_t areaAlong(double position, uint32_t areas) {
  return static_cast<uint32_t>(std::clamp(position / (1u << kAreaLog2), 0.0, areas - 0.5));
}

}  // namespace

std::optional<uint32_t> areaOf(const proto::GridShape& shape, const glm::dvec2& lattice) {
  const uint32_t columns = areasOf(shape.samples_x), rows = areasOf(shape.samples_y);
  if (columns * rows == 1 || !std::isfinite(lattice.x) || !std::isfinite(lattice.y)) return std::nullopt;
  return areaAlong(lattice.y, rows) * columns + areaAlong(lattice.x, columns);
}

}  // namespace foreland::client
