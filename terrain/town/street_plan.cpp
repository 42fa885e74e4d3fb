#include "terrain/town/street_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>
#include <tuple>

#include "base/check.h"
#include "base/rng.h"
#include "terrain/synth/noise.h"

namespace foreland::terrain {

namespace {

using glm::dvec2;

constexpr double kPlace_m = 96;                      // the side of the place in the middle
constexpr double kWarp_m = 26, kWarpLength_m = 600;  // how far streets bend, and over what length
constexpr uint32_t kFewestInBlock = 6;               // for the number of blocks; most hold twice as many

double cross(const dvec2& a, const dvec2& b) { return a.x * b.y - a.y * b.x; }
dvec2 leftOf(const dvec2& d) { return {-d.y, d.x}; }

// The ground of a building: a rectangle, turned.
struct Ground {
  dvec2 middle, x, y;  // unit axes
  dvec2 half;
  std::array<dvec2, 4> corners() const {
    const dvec2 a = x * half.x, b = y * half.y;
    return {middle - a - b, middle + a - b, middle + a + b, middle - a + b};
  }
};

bool overlap(const Ground& one, const Ground& other) {
  const auto isApart = [](const Ground& a, const Ground& b) {
    for (int axis = 0; axis < 2; ++axis) {
      const dvec2 direction = axis == 0 ? a.x : a.y;
      double least = INFINITY, most = -INFINITY;
      for (const dvec2& c : b.corners()) {
        least = std::min(least, glm::dot(direction, c - a.middle));
        most = std::max(most, glm::dot(direction, c - a.middle));
      }
      if (least > a.half[axis] || most < -a.half[axis]) return true;
    }
    return false;
  };
  return !isApart(one, other) && !isApart(other, one);
}

// A block between streets, counter-clockwise.
struct Block {
  std::array<dvec2, 4> corners;
  double distance = 0;  // of its middle from the town's
  bool is_place = false;

  bool holds(const Ground& ground) const {
    for (size_t side = 0; side < 4; ++side) {
      const dvec2 a = corners[side], along = glm::normalize(corners[(side + 1) % 4] - a);
      for (const dvec2& c : ground.corners())
        if (cross(along, c - a) < -1e-6) return false;
    }
    return true;
  }
};

// The lines of streets on one axis, from -count to count blocks; the place lies between lines 0 and 1.
struct StreetLines {
  std::vector<double> at, half_width;
};
StreetLines drawLines(int count, Rng& rng) {
  StreetLines lines;
  const auto size = 2 * static_cast<size_t>(count) + 2;
  lines.at.resize(size), lines.half_width.resize(size);
  for (double& half : lines.half_width) half = rng.uniform(6.5, 9.5);
  const auto middle = static_cast<size_t>(count);
  lines.at[middle] = -kPlace_m / 2, lines.at[middle + 1] = kPlace_m / 2;
  const auto pitch = [&](size_t from, size_t to) {
    return rng.uniform(62, 96) + lines.half_width[from] + lines.half_width[to];
  };
  for (size_t i = middle + 1; i + 1 < size; ++i) lines.at[i + 1] = lines.at[i] + pitch(i, i + 1);
  for (size_t i = middle; i > 0; --i) lines.at[i - 1] = lines.at[i] - pitch(i, i - 1);
  return lines;
}

dvec2 warped(const dvec2& p, uint32_t seed) {
  const dvec2 q = p / kWarpLength_m;
  return p + kWarp_m * dvec2(noise(q.x, q.y, seed), noise(q.x, q.y, seed + 1));
}

// Where the sides of a quadrilateral meet when each has been moved in by its share.
std::array<dvec2, 4> inset(const std::array<dvec2, 4>& corners, const std::array<double, 4>& by) {
  std::array<dvec2, 4> moved;
  for (size_t i = 0; i < 4; ++i) {
    const size_t before = (i + 3) % 4;
    const dvec2 d = glm::normalize(corners[(i + 1) % 4] - corners[i]), e = glm::normalize(corners[i] - corners[before]);
    const dvec2 p = corners[i] + leftOf(d) * by[i], q = corners[before] + leftOf(e) * by[before];
    moved[i] = q + e * (cross(p - q, d) / cross(e, d));
  }
  return moved;
}

std::vector<Block> layBlocks(int count, uint64_t seed) {
  Rng rng(seed);
  const StreetLines xs = drawLines(count, rng), ys = drawLines(count, rng);
  const auto warp = static_cast<uint32_t>(rng.next());
  std::vector<Block> blocks;
  for (size_t j = 0; j + 1 < ys.at.size(); ++j)
    for (size_t i = 0; i + 1 < xs.at.size(); ++i) {
      const auto corner = [&](size_t x, size_t y) { return warped({xs.at[x], ys.at[y]}, warp); };
      const std::array corners{corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)};
      Block block{inset(corners, {ys.half_width[j], xs.half_width[i + 1], ys.half_width[j + 1], xs.half_width[i]})};
      block.is_place = i == static_cast<size_t>(count) && j == i;
      block.distance = glm::length((corners[0] + corners[1] + corners[2] + corners[3]) / 4.0);
      blocks.push_back(block);
    }
  std::ranges::sort(blocks, {}, [](const Block& b) { return std::tuple(b.distance, b.corners[0].x, b.corners[0].y); });
  return blocks;
}

class Planner {
 public:
  Planner(uint32_t count, std::span<const Building> buildings, Rng& rng)
      : count_(count), buildings_(buildings), rng_(rng) {}

  void fill(const Block& block) {
    grounds_.clear();
    if (block.is_place) return fillPlace(block);
    for (size_t side = 0; side < 4; ++side) placeCorner(block, side);
    for (size_t side = 0; side < 4; ++side) placeRow(block, side);
  }
  bool isDone() const { return placed_.size() >= count_; }
  std::vector<PlacedBuilding> take() { return std::move(placed_); }

 private:
  // With the front on the right of `along`.
  bool place(const Block& block, uint32_t building, const dvec2& middle, const dvec2& along) {
    const Building& b = buildings_[building];
    const Ground ground{middle, along, leftOf(along), b.size / 2.0};
    const auto isInTheWay = [&](const Ground& other) { return overlap(ground, other); };
    if (isDone() || !block.holds(ground) || std::ranges::any_of(grounds_, isInTheWay)) return false;
    grounds_.push_back(ground);
    placed_.push_back({building, middle, std::atan2(ground.y.x, ground.y.y)});
    return true;
  }
  std::optional<uint32_t> choose(BuildingUse use) {
    std::vector<uint32_t> of_use;
    for (uint32_t i = 0; i < buildings_.size(); ++i)
      if (buildings_[i].use == use) of_use.push_back(i);
    if (of_use.empty()) return std::nullopt;
    return of_use[rng_.below(of_use.size())];
  }

  void fillPlace(const Block& block) {
    const dvec2 along = glm::normalize(block.corners[1] - block.corners[0]);
    const dvec2 middle = (block.corners[0] + block.corners[1] + block.corners[2] + block.corners[3]) / 4.0;
    if (const auto church = choose(BuildingUse::kChurch)) place(block, *church, middle + 14.0 * leftOf(along), along);
    if (const auto tower = choose(BuildingUse::kTower))
      place(block, *tower, middle - 24.0 * along - 20.0 * leftOf(along), along);
  }
  // A building whose wings lie along the sides that meet in a corner.
  void placeCorner(const Block& block, size_t side) {
    const auto building = choose(BuildingUse::kCorner);
    if (!building || rng_.below(3) == 0) return;
    const dvec2 at = block.corners[side], along = glm::normalize(block.corners[(side + 1) % 4] - at);
    const dvec2 half = buildings_[*building].size / 2.0;
    // Blocks are no squares, so it moves in until it is within.
    for (double in = 0; in < 4; in += 0.25)
      if (place(block, *building, at + (half.x + in) * along + (half.y + in) * leftOf(along), along)) return;
  }
  void placeRow(const Block& block, size_t side) {
    const dvec2 at = block.corners[side], to = block.corners[(side + 1) % 4];
    const dvec2 along = glm::normalize(to - at), in = leftOf(along);
    const double length = glm::length(to - at);
    for (double begin = 0; begin < length;) {
      double step = 1;
      for (int attempt = 0; attempt < 4; ++attempt) {
        const auto building = choose(BuildingUse::kHouse);
        if (!building) return;
        const dvec2 size = buildings_[*building].size;
        const double back = rng_.below(4) == 0 ? rng_.uniform(0, 1.5) : 0;
        if (!place(block, *building, at + (begin + size.x / 2) * along + (back + size.y / 2) * in, along)) continue;
        step = size.x + (rng_.below(5) == 0 ? rng_.uniform(2, 6) : 0.1);
        break;
      }
      begin += step;
    }
  }

  uint32_t count_;
  std::span<const Building> buildings_;
  Rng& rng_;
  std::vector<Ground> grounds_;  // in the block
  std::vector<PlacedBuilding> placed_;
};

}  // namespace

StreetPlan planStreets(uint32_t count, std::span<const Building> buildings, uint64_t seed) {
  CHECK_GT(count, 0u);
  Rng rng(seed);
  const auto blocks_aside = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count) / kFewestInBlock) / 2)) + 1;
  Planner planner(count, buildings, rng);
  const double heading = rng.uniform(0, 0.5), c = std::cos(heading), s = std::sin(heading);
  for (const Block& block : layBlocks(blocks_aside, rng.next()))
    if (!planner.isDone()) planner.fill(block);
  StreetPlan plan{planner.take(), 0};
  for (PlacedBuilding& b : plan.buildings) {
    b.at = {c * b.at.x + s * b.at.y, c * b.at.y - s * b.at.x};
    b.heading_rad += heading;
    plan.radius_m = std::max(plan.radius_m, glm::length(b.at) + glm::length(buildings[b.building].size) / 2);
  }
  return plan;
}

}  // namespace foreland::terrain
