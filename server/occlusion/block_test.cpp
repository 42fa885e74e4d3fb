#include "server/occlusion/block_test.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace foreland::server {

namespace {

constexpr double kNearest_m = 1;    // of a block that may be hidden
constexpr double kMaxAside = 0.8;   // wider blocks are too near
constexpr double kWidest = 1.3;     // horizontal distance over distance ahead, at most
constexpr double kFinest_px = 0.5;  // half of an interval
constexpr int kFirstHalvings = 2, kMaxHalvings = 6;
constexpr uint32_t kSquares = proto::BlockId::kSide / 2;  // a side
constexpr double kNothing = -std::numeric_limits<double>::infinity();

}  // namespace

bool BlockTest::isHidden(const proto::BlockId& block, const Tolerance& tolerance_of, const EyeCapsule& eyes,
                         uint64_t max_rays) {
  if (block.scale < scene_.tops.finestScale()) return false;
  last_ray_ = rays_ + max_rays;
  return collectSquares(block, eyes.eye) && raiseEye(tolerance_of, eyes) && isCovered(low_, high_, 0);
}

// As one square, a scale coarser, or else as the squares of its own.
bool BlockTest::isBehind(const proto::BlockId& block, const Tolerance& tolerance, Horizon& horizon) const {
  static_assert(kSquares == 2);
  const uint32_t scale = block.scale, i = 2 * block.x, j = 2 * block.y;
  if (scene_.globe ? scene_.globe->squares.isAtSeam(block) : scale < scene_.tops.finestScale()) return false;
  if (hasSquare(scale + 1, block.x, block.y) && isBehind(scale + 1, block.x, block.y, tolerance, horizon)) return true;
  for (const auto& [x, y] : {std::pair{i, j}, {i + 1, j}, {i, j + 1}, {i + 1, j + 1}})
    if (hasSquare(scale, x, y) && !isBehind(scale, x, y, tolerance, horizon)) return false;
  return hasSquare(scale, i, j);
}

// Of a block of a globe that lies within a face all squares do.
bool BlockTest::hasSquare(uint32_t scale, uint32_t i, uint32_t j) const {
  return scene_.globe || scene_.tops.has(scale, i, j);
}

bool BlockTest::isBehind(uint32_t scale, uint32_t i, uint32_t j, const Tolerance& tolerance, Horizon& horizon) const {
  if (!scene_.globe) return isBehind(squareIn(scale, i, j), tolerance, horizon);
  const auto hull = scene_.globe->squares.hullOf(scale, i, j);
  return hull && isHullBehind(*hull, tolerance, horizon);
}

// In a box along the axes of the grid; not if lines to it are so steep that the grid has no room for what is drawn
// (horizon.h).
bool BlockTest::isHullBehind(const GlobeSquares::Hull& hull, const Tolerance& tolerance, Horizon& horizon) const {
  const HorizonGrid& grid = horizon.grid();
  glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
  for (const glm::dvec3& corner : hull.corners) {
    const glm::dvec3 p = grid.toAxes(corner);
    low = glm::min(low, p), high = glm::max(high, p);
  }
  low -= hull.error_m, high += hull.error_m;
  const Horizon::Square square{grid.toGrid(glm::dvec2(low)), grid.toGrid(glm::dvec2(high)), high.z, high.z,
                               glm::dvec2(0)};
  const double from_m = horizon.beginHeight(), size_m = glm::length(glm::dvec2(high - low)),
               distance_m = glm::length(grid.toScene(square.low - horizon.begin())) - size_m - horizon.extent(),
               drop_m = std::max(high.z - from_m, from_m - low.z) + horizon.extent();
  return drop_m < distance_m && isBehind(square, tolerance, horizon);
}

bool BlockTest::isBehind(std::span<const glm::dvec3> points, const Tolerance& tolerance, Horizon& horizon) const {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Horizon::Square square{glm::dvec2(kFar), glm::dvec2(-kFar), -kFar, -kFar, glm::dvec2(0)};
  for (const glm::dvec3& point : points) {
    const glm::dvec3 p = horizon.grid().toAxes(point);
    const glm::dvec2 at = horizon.grid().toGrid(glm::dvec2(p));
    square.low = glm::min(square.low, at);
    square.high = glm::max(square.high, at);
    square.top_m = square.height_m = std::max(square.top_m, p.z);
  }
  return isBehind(square, tolerance, horizon);
}

std::array<glm::dvec3, 8> BlockTest::cornersOf(uint32_t scale, uint32_t i, uint32_t j) const {
  const proto::GridTopology& grid = hierarchy_.grid();
  const BlockTops::Square& square = scene_.tops.square(scale, i, j);
  const uint32_t side = 2u << scale;
  std::array<glm::dvec3, 8> corners;
  for (uint32_t c = 0; c < 8; ++c) {
    const uint32_t x = std::min((i + (c & 1)) * side, grid.maxX()),
                   y = std::min((j + (c >> 1 & 1)) * side, grid.maxY());
    corners[c] = hierarchy_.frame().position(proto::NodeId::at(x, y), (c & 4) != 0 ? square.top : square.bottom);
  }
  return corners;
}

// By so much as the surface may be drawn lower, where the horizon is.
bool BlockTest::isBehind(Horizon::Square s, const Tolerance& tolerance, Horizon& horizon) const {
  const HorizonGrid& grid = horizon.grid();
  const glm::dvec2 size = s.high - s.low;
  const double side = grid.isOverGlobe() ? glm::length(size) : std::max(size.x, size.y),
               spread = horizon.extent() + grid.metresOfStep() * side,
               distance_m = glm::length(grid.toScene(s.low - horizon.begin()));
  if (distance_m < 2 * spread) return false;
  // A vertical error e is seen as f e h / d^2 at the horizontal distance h and the distance d.
  const double drop = std::fabs(s.top_m - horizon.beginHeight()) + spread,
               raise = tolerance.tau_px / tolerance.lens.focalPx() *
                       (distance_m + spread + drop * drop / (distance_m - spread));
  s.top_m += raise;
  s.height_m += raise;
  return horizon.hides(s);
}

// In geographic scenes a square is not one of the grid, nor is what is plane in the lattice plane in the scene.
Horizon::Square BlockTest::squareIn(uint32_t scale, uint32_t i, uint32_t j) const {
  const HorizonGrid& grid = *scene_.grid;
  const BlockTops::Square& square = scene_.tops.square(scale, i, j);
  if (grid.isLattice()) {
    const double side = (2u << scale) * grid.stepsOfSample(), quantum_m = grid.heightQuantum();
    const glm::dvec2 low(i * side, j * side);
    return {low, low + side, square.top * quantum_m, square.height * quantum_m,
            glm::dvec2(square.tilt_x, square.tilt_y) * quantum_m};
  }
  const uint32_t side = 2u << scale;
  const HorizonGrid::Bounds bounds = grid.boundsOf(hierarchy_.frame(), {i * side, j * side},
                                                   {(i + 1) * side, (j + 1) * side}, square.bottom, square.top);
  return {bounds.low, bounds.high, bounds.top_m, bounds.top_m, glm::dvec2(0)};
}

bool BlockTest::collectSquares(const proto::BlockId& block, const glm::dvec3& eye) {
  const proto::GridTopology& grid = hierarchy_.grid();
  const auto position = [&](uint32_t x, uint32_t y, int32_t height) {
    return hierarchy_.frame().position(proto::NodeId::at(std::min(x, grid.maxX()), std::min(y, grid.maxY())), height);
  };
  const uint32_t side = 2u << block.scale, i0 = block.x * kSquares, j0 = block.y * kSquares;
  const glm::dvec2 middle(position((i0 + kSquares / 2) * side, (j0 + kSquares / 2) * side, 0) - eye);
  if (glm::length(middle) < kNearest_m) return false;
  ahead_.ahead = glm::normalize(middle);
  ahead_.aside = {-ahead_.ahead.y, ahead_.ahead.x};
  ahead_.length_m = low_ = std::numeric_limits<double>::infinity();
  high_ = -low_;
  squares_.clear();
  const uint32_t i1 = std::min(i0 + kSquares, scene_.tops.columns(block.scale)),
                 j1 = std::min(j0 + kSquares, scene_.tops.rows(block.scale));
  for (uint32_t j = j0; j < j1; ++j)
    for (uint32_t i = i0; i < i1; ++i) {
      const int32_t top = scene_.tops.square(block.scale, i, j).top;
      constexpr double kFar = std::numeric_limits<double>::infinity();
      Square square{kFar, -kFar, kFar, 0, -kFar, 0};
      for (uint32_t corner = 0; corner < 4; ++corner) {
        const glm::dvec3 p = position((i + (corner & 1)) * side, (j + (corner >> 1)) * side, top) - eye;
        const double forward = glm::dot(glm::dvec2(p), ahead_.ahead);
        if (forward < kNearest_m) return false;
        const double aside = glm::dot(glm::dvec2(p), ahead_.aside) / forward;
        square.nearest = std::min(square.nearest, forward);
        square.farthest = std::max(square.farthest, forward);
        square.height = std::max(square.height, p.z);
        square.aside_low = std::min(square.aside_low, aside);
        square.aside_high = std::max(square.aside_high, aside);
      }
      if (square.aside_low < -kMaxAside || square.aside_high > kMaxAside) return false;
      squares_.push_back(square);
      ahead_.length_m = std::min(ahead_.length_m, square.nearest);
      low_ = std::min(low_, square.aside_low);
      high_ = std::max(high_, square.aside_high);
    }
  return !squares_.empty();
}

// Raises the eye by what all eyes of the capsule and all points of the block need, then has each square's slope. False
// if the capsule reaches the block.
bool BlockTest::raiseEye(const Tolerance& tolerance_of, const EyeCapsule& eyes) {
  const double k = scene_.occluder->steepness(),
               tolerance = tolerance_of.tau_px / tolerance_of.lens.focalPx() * kWidest;
  const double x = glm::dot(glm::dvec2(eyes.way), ahead_.ahead), y = glm::dot(glm::dvec2(eyes.way), ahead_.aside);
  ahead_.begin_m = std::max(0.0, x);
  if (ahead_.length_m - ahead_.begin_m < kNearest_m + eyes.radius_m) return false;
  const auto slopeOf = [](const Square& s, double height) { return height / (height > 0 ? s.nearest : s.farthest); };
  double lowest = std::numeric_limits<double>::infinity(), highest = 0;
  for (const Square& s : squares_) {
    lowest = std::min(lowest, s.height / (s.height > 0 ? s.farthest : s.nearest));
    const double slope = slopeOf(s, s.height);
    highest = std::max(highest, slope + tolerance * (1 + slope * slope));
  }
  highest += 0.5 * k * (high_ - low_);
  const double ball = eyes.radius_m * std::sqrt(1 + k * k);
  const double aside = std::max(std::fabs(y - low_ * x), std::fabs(y - high_ * x));
  const double by_way = eyes.way.z + k * aside - (x > 0 ? lowest : highest) * x;
  const double raise = ahead_.length_m / (ahead_.length_m - ahead_.begin_m) * (ball + std::max(0.0, by_way)) +
                       tolerance * (1 + highest * highest) * std::max(0.0, -x);
  finest_ = kFinest_px / tolerance_of.lens.focalPx();
  ahead_.start = eyes.eye + glm::dvec3(0, 0, raise);
  for (Square& s : squares_) {
    const double slope = slopeOf(s, s.height - raise);
    // A vertical error e is seen as f e h / d^2 at the horizontal distance h and the distance d = h sqrt(1 +
    // slope^2).
    s.slope = slope + tolerance * (1 + slope * slope);
  }
  return true;
}

// What a line of sight must rise by to pass over all squares between two directions.
double BlockTest::slopeOver(double low, double high) const {
  double slope = kNothing;
  for (const Square& s : squares_)
    if (s.aside_low <= high && s.aside_high >= low) slope = std::max(slope, s.slope);
  return slope;
}

bool BlockTest::isBlocked(double aside, double slope) {
  ++rays_;
  const glm::dvec3 line(ahead_.ahead + aside * ahead_.aside, slope);
  return scene_.occluder->blocks(ahead_.start + ahead_.begin_m * line, (ahead_.length_m - ahead_.begin_m) * line);
}

// The margin of a wide interval is so large that its line hardly ever is blocked.
bool BlockTest::isCovered(double low, double high, int halvings) {
  const double middle = 0.5 * (low + high), half = 0.5 * (high - low), slope = slopeOver(low, high);
  if (slope == kNothing) return true;
  if (rays_ >= last_ray_) return false;
  if (halvings >= kFirstHalvings && isBlocked(middle, slope + scene_.occluder->steepness() * half)) return true;
  if (halvings == kMaxHalvings || half < finest_) return false;
  const double bare = slopeOver(middle, middle);
  if (bare != kNothing && !isBlocked(middle, bare)) return false;
  return isCovered(low, middle, halvings + 1) && isCovered(middle, high, halvings + 1);
}

}  // namespace foreland::server
