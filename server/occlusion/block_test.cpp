#include "server/occlusion/block_test.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace foreland::server {

namespace {

constexpr double kNearest_m = 1;    // of a block that may be hidden
constexpr double kMostAside = 0.8;  // wider blocks are too near
constexpr double kWidest = 1.3;     // horizontal distance over distance ahead, at most
constexpr double kFinest_px = 0.5;  // half of an interval
constexpr int kMaxDepth = 5;
constexpr uint32_t kSquares = proto::BlockId::kSide / 2;  // a side

}  // namespace

bool BlockTest::isHidden(const proto::BlockId& block, const proto::View& view, double radius_m, uint64_t max_rays) {
  if (block.scale < tops_.finestScale()) return false;
  const double k = occluder_.steepness();
  Ahead ahead;
  ahead.eye = view.pose.eye + glm::dvec3(0, 0, radius_m * std::sqrt(1 + k * k));
  finest_ = kFinest_px / view.lens.focalPx();
  last_ray_ = rays_ + max_rays;
  return collectSquares(block, view, ahead) && isCovered(ahead, low_, high_, 0);
}

bool BlockTest::collectSquares(const proto::BlockId& block, const proto::View& view, Ahead& ahead) {
  const proto::GridTopology& grid = hierarchy_.grid();
  const auto position = [&](uint32_t x, uint32_t y, int32_t height) {
    return hierarchy_.frame().position(proto::NodeId::at(std::min(x, grid.maxX()), std::min(y, grid.maxY())), height);
  };
  const uint32_t side = 2u << block.scale, i0 = block.x * kSquares, j0 = block.y * kSquares;
  const glm::dvec2 middle(position((i0 + kSquares / 2) * side, (j0 + kSquares / 2) * side, 0) - ahead.eye);
  if (glm::length(middle) < kNearest_m) return false;
  ahead.ahead = glm::normalize(middle);
  ahead.aside = {-ahead.ahead.y, ahead.ahead.x};
  ahead.length_m = low_ = std::numeric_limits<double>::infinity();
  high_ = -low_;
  squares_.clear();
  const uint32_t i1 = std::min(i0 + kSquares, tops_.columns(block.scale)),
                 j1 = std::min(j0 + kSquares, tops_.rows(block.scale));
  for (uint32_t j = j0; j < j1; ++j)
    for (uint32_t i = i0; i < i1; ++i) {
      const int32_t top = tops_.top(block.scale, i, j);
      double nearest = std::numeric_limits<double>::infinity(), farthest = 0, highest = -nearest;
      Square square{nearest, -nearest, 0};
      for (uint32_t corner = 0; corner < 4; ++corner) {
        const glm::dvec3 p = position((i + (corner & 1)) * side, (j + (corner >> 1)) * side, top) - ahead.eye;
        const double forward = glm::dot(glm::dvec2(p), ahead.ahead);
        if (forward < kNearest_m) return false;
        const double aside = glm::dot(glm::dvec2(p), ahead.aside) / forward;
        nearest = std::min(nearest, forward);
        farthest = std::max(farthest, forward);
        highest = std::max(highest, p.z);
        square.aside_low = std::min(square.aside_low, aside);
        square.aside_high = std::max(square.aside_high, aside);
      }
      if (square.aside_low < -kMostAside || square.aside_high > kMostAside) return false;
      const double slope = highest / (highest > 0 ? nearest : farthest);
      // A vertical error e is seen as f e h / d^2 at the horizontal distance h and the distance d = h sqrt(1 +
      // slope^2).
      square.slope = slope + view.tau_px / view.lens.focalPx() * kWidest * (1 + slope * slope);
      squares_.push_back(square);
      ahead.length_m = std::min(ahead.length_m, nearest);
      low_ = std::min(low_, square.aside_low);
      high_ = std::max(high_, square.aside_high);
    }
  return !squares_.empty();
}

// What a line of sight must rise by to pass over all squares between two directions.
double BlockTest::slopeOver(double low, double high) const {
  double slope = -std::numeric_limits<double>::infinity();
  for (const Square& s : squares_)
    if (s.aside_low <= high && s.aside_high >= low) slope = std::max(slope, s.slope);
  return slope;
}

bool BlockTest::isBlocked(const Ahead& ahead, double aside, double slope) {
  ++rays_;
  const glm::dvec2 level = ahead.ahead + aside * ahead.aside;
  return occluder_.blocks(ahead.eye, ahead.length_m * glm::dvec3(level, slope));
}

bool BlockTest::isCovered(const Ahead& ahead, double low, double high, int depth) {
  const double middle = 0.5 * (low + high), half = 0.5 * (high - low);
  const double slope = slopeOver(low, high);
  if (slope == -std::numeric_limits<double>::infinity()) return true;
  if (rays_ >= last_ray_) return false;
  if (isBlocked(ahead, middle, slope + occluder_.steepness() * half)) return true;
  if (depth == kMaxDepth || half < finest_) return false;
  const double bare = slopeOver(middle, middle);
  if (bare > -std::numeric_limits<double>::infinity() && !isBlocked(ahead, middle, bare)) return false;
  return isCovered(ahead, low, middle, depth + 1) && isCovered(ahead, middle, high, depth + 1);
}

}  // namespace foreland::server
