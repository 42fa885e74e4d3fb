#include "terrain/dem/vertical/fit_undulations.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace foreland::terrain {

namespace {

constexpr uint32_t kFirstSide = 3, kMostSide = 1025;
constexpr double kOnLine = 1e-6;  // of a step: rounding

// Fills the grid row by row. False if a value is not known.
bool fill(proto::UndulationGrid& grid, const UndulationsAt& at) {
  std::vector<glm::dvec2> places(grid.columns);
  std::vector<double> row_m(grid.columns);
  for (uint32_t row = 0; row < grid.rows; ++row) {
    for (uint32_t column = 0; column < grid.columns; ++column)
      places[column] = grid.first + glm::dvec2(column, row) * grid.step;
    at(places, row_m);
    if (std::ranges::any_of(row_m, [](double n) { return !std::isfinite(n); })) return false;
    for (const double n : row_m) grid.metres.push_back(static_cast<float>(n));
  }
  return true;
}

// The largest difference from the geoid in the middles of cells and of sides, at most at the samples' border.
double largestError(const proto::UndulationGrid& grid, glm::dvec2 last, const UndulationsAt& at) {
  std::vector<glm::dvec2> places;
  std::vector<double> row_m;
  double largest_m = 0;
  for (uint32_t row = 0; row + 1 < 2 * grid.rows; ++row) {
    places.clear();
    for (uint32_t column = 0; column + 1 < 2 * grid.columns; ++column) {
      if (row % 2 == 0 && column % 2 == 0) continue;  // a value of the grid
      const glm::dvec2 p = grid.first + glm::dvec2(column, row) * 0.5 * grid.step;
      places.emplace_back(std::clamp(p.x, 0.0, last.x), std::clamp(p.y, 0.0, last.y));
    }
    row_m.resize(places.size());
    at(places, row_m);
    for (size_t i = 0; i < places.size(); ++i)
      if (std::isfinite(row_m[i])) largest_m = std::max(largest_m, std::fabs(row_m[i] - grid.at(places[i])));
  }
  return largest_m;
}

// Along one axis: the line at or before 0, and how many lines reach to `last`.
struct Covering {
  double first;
  uint32_t count;
};
std::optional<Covering> cover(double line, double step, double last) {
  const double begin = std::floor(-line / step + kOnLine), end = std::ceil((last - line) / step - kOnLine);
  const double count = std::max(2.0, end - begin + 1);
  if (!(count <= proto::UndulationGrid::kMaxValues)) return std::nullopt;
  return Covering{line + begin * step, static_cast<uint32_t>(count)};
}

std::optional<proto::UndulationGrid> onLines(const LatticeLines& lines, glm::dvec2 last) {
  const auto x = cover(lines.first.x, lines.step.x, last.x), y = cover(lines.first.y, lines.step.y, last.y);
  if (!x || !y || uint64_t{x->count} * y->count > proto::UndulationGrid::kMaxValues) return std::nullopt;
  proto::UndulationGrid grid;
  grid.first = {x->first, y->first};
  grid.step = lines.step;
  grid.columns = x->count;
  grid.rows = y->count;
  return grid;
}

}  // namespace

std::optional<proto::UndulationGrid> fitUndulations(uint32_t width, uint32_t height,
                                                    const std::optional<LatticeLines>& lines, const UndulationsAt& at) {
  const glm::dvec2 last(width - 1.0, height - 1.0);
  auto grid = lines ? onLines(*lines, last) : std::nullopt;
  if (grid && fill(*grid, at)) {
    grid->max_error_m = largestError(*grid, last, at);
    return grid;
  }
  for (uint32_t side = kFirstSide;; side = 2 * side - 1) {
    proto::UndulationGrid even;
    even.step = last / (side - 1.0);
    even.columns = even.rows = side;
    if (!fill(even, at)) return std::nullopt;
    even.max_error_m = largestError(even, last, at);
    if (even.max_error_m <= kGoodEnough_m || side >= kMostSide) return even;
  }
}

}  // namespace foreland::terrain
