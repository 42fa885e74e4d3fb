#include "proto/space/vertical.h"

#include <algorithm>
#include <cmath>

namespace foreland::proto {

namespace {

constexpr double kMaxUndulation_m = 1e4;  // far more than any body's

struct Cell {
  size_t index;
  double share;
};

// Which of the intervals between `count` values a position is in, and how far.
Cell cellOf(double position, uint32_t count) {
  const double inside = std::isfinite(position) ? std::clamp(position, 0.0, count - 1.0) : 0.0;
  const size_t index = std::min(static_cast<size_t>(inside), size_t{count} - 2);
  return {index, inside - static_cast<double>(index)};
}

bool isFinite(glm::dvec2 v) { return std::isfinite(v.x) && std::isfinite(v.y); }

Error refused(const char* what) { return {ErrorCode::kMalformed, what}; }

}  // namespace

double UndulationGrid::at(glm::dvec2 lattice) const {
  const Cell x = cellOf((lattice.x - first.x) / step.x, columns), y = cellOf((lattice.y - first.y) / step.y, rows);
  const float* south = metres.data() + y.index * columns + x.index;
  const float* north = south + columns;
  return (1 - y.share) * ((1 - x.share) * south[0] + x.share * south[1]) +
         y.share * ((1 - x.share) * north[0] + x.share * north[1]);
}

Status UndulationGrid::validate() const {
  if (columns == 0 && rows == 0 && metres.empty()) return {};
  if (columns < 2 || rows < 2 || uint64_t{columns} * rows > kMaxValues || uint64_t{columns} * rows != metres.size())
    return refused("its undulations are not of a grid");
  if (!isFinite(first) || !isFinite(step) || !(step.x > 0 && step.y > 0) || !(max_error_m >= 0) ||
      !std::isfinite(max_error_m))
    return refused("its undulations are nowhere");
  const auto isAbsurd = [](float n) { return !(std::fabs(n) <= kMaxUndulation_m); };
  if (std::ranges::any_of(metres, isAbsurd)) return refused("an undulation is absurdly large");
  return {};
}

Status VerticalDatum::validate() const {
  if (zero_surface > ZeroSurface::kGeoid) return refused("its heights are above an unknown kind of surface");
  if ((zero_surface == ZeroSurface::kUnstated) != name.empty())
    return refused("its vertical datum lacks a name or a kind");
  if (geoid.empty() != undulations.isEmpty()) return refused("its undulations lack a geoid or values");
  return undulations.validate();
}

std::optional<BothHeights> bothHeights(const VerticalDatum& datum, glm::dvec2 lattice, double height_m) {
  if (datum.zero_surface == ZeroSurface::kUnstated || datum.undulations.isEmpty()) return std::nullopt;
  const double undulation_m = datum.undulations.at(lattice);
  if (datum.zero_surface == ZeroSurface::kGeoid) return BothHeights{height_m, height_m + undulation_m};
  return BothHeights{height_m - undulation_m, height_m};
}

UndulationGrid thinned(const UndulationGrid& grid, uint32_t most) {
  if (grid.isEmpty() || (grid.columns <= most && grid.rows <= most)) return grid;
  UndulationGrid out;
  out.first = grid.first;
  out.columns = std::min(grid.columns, most);
  out.rows = std::min(grid.rows, most);
  out.step = {grid.step.x * (grid.columns - 1.0) / (out.columns - 1.0),
              grid.step.y * (grid.rows - 1.0) / (out.rows - 1.0)};
  for (uint32_t row = 0; row < out.rows; ++row)
    for (uint32_t column = 0; column < out.columns; ++column)
      out.metres.push_back(static_cast<float>(grid.at(out.first + glm::dvec2(column, row) * out.step)));
  // The difference of two bilinear surfaces is largest at corners of the cells of either.
  double lost_m = 0;
  const auto compare = [&](double x, double y) {
    lost_m = std::max(lost_m, std::fabs(out.at({x, y}) - grid.at({x, y})));
  };
  for (uint32_t row = 0; row < grid.rows; ++row)
    for (uint32_t column = 0; column < grid.columns; ++column)
      compare(grid.first.x + column * grid.step.x, grid.first.y + row * grid.step.y);
  for (uint32_t row = 0; row < out.rows; ++row)
    for (uint32_t column = 0; column < grid.columns; ++column)
      compare(grid.first.x + column * grid.step.x, out.first.y + row * out.step.y);
  for (uint32_t row = 0; row < grid.rows; ++row)
    for (uint32_t column = 0; column < out.columns; ++column)
      compare(out.first.x + column * out.step.x, grid.first.y + row * grid.step.y);
  out.max_error_m = grid.max_error_m + lost_m;
  return out;
}

}  // namespace foreland::proto
