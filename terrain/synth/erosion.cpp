#include "terrain/synth/erosion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>

#include "terrain/synth/noise.h"

namespace foreland::terrain {

namespace {

struct Neighbour {
  int dx, dy;
  float distance;
};
constexpr std::array<Neighbour, 8> kNeighbours{{{1, 0, 1},
                                                {-1, 0, 1},
                                                {0, 1, 1},
                                                {0, -1, 1},
                                                {1, 1, 1.41421356f},
                                                {-1, 1, 1.41421356f},
                                                {1, -1, 1.41421356f},
                                                {-1, -1, 1.41421356f}}};

// Half would be the textbook's; less makes brooks gentler and trunk valleys steeper, as in young mountains.
constexpr double kAreaExponent = 0.45;

struct Front {
  float height;
  uint32_t cell;
  bool operator>(const Front& o) const { return height != o.height ? height > o.height : cell > o.cell; }
};

bool isBorder(uint32_t cell, uint32_t size) {
  const uint32_t x = cell % size, y = cell / size;
  return x == 0 || y == 0 || x == size - 1 || y == size - 1;
}

}  // namespace

// Floods from the border inward in order of height. Water goes down the steepest slope; where there is none, the way
// the flood came.
void Eroder::routeWater(const ErosionGrid& grid, uint32_t seed) {
  const uint32_t n = grid.size, cells = n * n;
  constexpr uint32_t kUnset = ~0u;
  receiver_.assign(cells, kUnset);
  filled_ = grid.height;
  order_.clear();
  order_.reserve(cells);
  std::priority_queue<Front, std::vector<Front>, std::greater<>> front;
  for (uint32_t cell = 0; cell < cells; ++cell)
    if (isBorder(cell, n)) {
      receiver_[cell] = cell;
      front.push({grid.height[cell], cell});
    }
  while (!front.empty()) {
    const uint32_t cell = front.top().cell;
    front.pop();
    order_.push_back(cell);
    if (receiver_[cell] != cell && filled_[cell] <= grid.height[cell]) {
      float steepest = 0;
      for (const Neighbour& d : kNeighbours) {
        const uint32_t other = cell + static_cast<uint32_t>(d.dy * static_cast<int>(n) + d.dx);
        if (receiver_[other] == kUnset) continue;  // a hollow the flood has yet to reach; it will drain through here
        const float chance =
            0.55f +
            0.9f * static_cast<float>(hashLattice(static_cast<int32_t>(cell), static_cast<int32_t>(other), seed) >> 8) *
                0x1p-24f;
        const float slope = chance * (grid.height[cell] - filled_[other]) / d.distance;
        if (slope > steepest) {
          steepest = slope;
          receiver_[cell] = other;
        }
      }
    }
    const uint32_t x = cell % n, y = cell / n;
    for (const Neighbour& d : kNeighbours) {
      const uint32_t u = x + static_cast<uint32_t>(d.dx), v = y + static_cast<uint32_t>(d.dy);
      if (u >= n || v >= n) continue;
      const uint32_t other = v * n + u;
      if (receiver_[other] != kUnset) continue;
      receiver_[other] = cell;
      // A lake's surface rises a little and unevenly, so that the river through it winds.
      const float chance = static_cast<float>(hashLattice(static_cast<int32_t>(other), 5, seed) >> 8) * 0x1p-24f;
      filled_[other] =
          std::max(grid.height[other], filled_[cell] + static_cast<float>(grid.cell) * 0.002f * (0.1f + chance));
      front.push({filled_[other], other});
    }
  }
}

void Eroder::collectArea(const ErosionGrid& grid) {
  area_.assign(grid.height.size(), 1.0f);
  for (size_t i = order_.size(); i-- > 0;) {
    const uint32_t cell = order_[i];
    if (receiver_[cell] != cell) area_[receiver_[cell]] += area_[cell];
  }
}

// Implicit, from the outlets upward: each cell's receiver already has its new height.
void Eroder::cut(ErosionGrid& grid, const ErosionStep& step) const {
  const uint32_t n = grid.size;
  for (const uint32_t cell : order_) {
    const uint32_t to = receiver_[cell];
    if (to == cell) continue;
    const uint32_t dx = cell % n > to % n ? cell % n - to % n : to % n - cell % n;
    const uint32_t dy = cell / n > to / n ? cell / n - to / n : to / n - cell / n;
    const double distance = grid.cell * (dx + dy == 2 ? 1.41421356237 : 1.0);
    const double factor =
        step.erodibility * step.time * std::pow(area_[cell] * grid.cell * grid.cell, kAreaExponent) / distance;
    const double lifted = grid.height[cell] + grid.uplift[cell] * step.time;
    const double below = grid.height[to];
    // A lake's floor lies below its outlet; sediment fills it to the brim.
    const double cut_to = lifted > below ? (lifted + factor * below) / (1 + factor) : below;
    const double rock =
        2.0 / 3 +
        2.0 / 3 * (hashLattice(static_cast<int32_t>(cell), static_cast<int32_t>(to), step.seed + 7) >> 8) * 0x1p-24;
    grid.height[cell] = static_cast<float>(std::min(cut_to, below + rock * step.talus * distance));
  }
}

void Eroder::creep(ErosionGrid& grid, double share) {
  const uint32_t n = grid.size;
  filled_ = grid.height;
  const auto s = static_cast<float>(share);
  for (uint32_t y = 1; y + 1 < n; ++y)
    for (uint32_t x = 1; x + 1 < n; ++x) {
      const float* h = filled_.data() + size_t{y} * n + x;
      grid.height[size_t{y} * n + x] = *h + s * (0.25f * (h[-1] + h[1] + *(h - n) + h[n]) - *h);
    }
}

void Eroder::run(ErosionGrid& grid, const ErosionStep& step) {
  routeWater(grid, step.seed);
  collectArea(grid);
  cut(grid, step);
  if (step.diffusion > 0) creep(grid, step.diffusion);
}

// From the outlets upward: a cell lies no lower than the floor that its water flows to, and a river's cell on its own
// gravel.
void Eroder::fillValleys(ErosionGrid& grid, const Alluvium& gravel) {
  constexpr double kFloorSlope = 0.012;
  constexpr double kDoublings = 9;  // of the area, until the gravel has its full depth
  routeWater(grid, gravel.seed);
  collectArea(grid);
  for (const uint32_t cell : order_) {
    const double area = area_[cell] * grid.cell * grid.cell;
    const double share = std::clamp(std::log2(area / gravel.min_area) / kDoublings, 0.0, 1.0);
    const double own = grid.height[cell] + gravel.depth * share;
    const uint32_t to = receiver_[cell];
    const double floor = to == cell ? own : std::max(own, grid.height[to] + kFloorSlope * grid.cell);
    grid.height[cell] = static_cast<float>(floor);
  }
  creep(grid, 0.5);
}

}  // namespace foreland::terrain
