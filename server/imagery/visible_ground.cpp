#include "server/imagery/visible_ground.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <utility>

namespace foreland::server {

namespace {

constexpr double kBin_px = 8;  // width of the horizon's bins
constexpr size_t kHorizons = 6;
constexpr double kPartsAcross = 4;  // a tile, at least, before they are split
constexpr uint32_t kMaxSplits = 3;

}  // namespace

VisibleGround::VisibleGround(std::span<const proto::TileLayer> layers, std::shared_ptr<const SceneGround> ground,
                             const proto::TileMemory& held)
    : layers_(layers), ground_(std::move(ground)), held_(held) {
  if (!ground_->grid) return;
  for (size_t i = 0; i < kHorizons; ++i) horizons_.push_back(std::make_unique<Horizon>(*ground_->grid));
}

void VisibleGround::look(const EyeCapsule& eyes, const proto::View& view) {
  tau_per_m_ = view.tau_px / view.lens.focalPx();
  if (horizons_.empty()) return;
  // One that was made for where the eye was expected to be by now, among others.
  const double bin = kBin_px / view.lens.focalPx();
  const auto known = std::find_if(horizons_.begin(), horizons_.end(), [&](const auto& horizon) {
    return horizon->bin() == bin && horizon->eyes().contains(eyes);
  });
  const auto chosen = known == horizons_.end() ? horizons_.end() - 1 : known;
  if (known == horizons_.end()) (*chosen)->look(eyes, bin);
  std::rotate(horizons_.begin(), chosen, chosen + 1);
}

// Beyond the outermost samples, half a texel, the ground is like that at the border.
bool VisibleGround::parts(const proto::TileId& tile, std::vector<proto::TilePart>& out) {
  if (held_.has(tile)) return false;
  const GroundSquares& squares = ground_->squares;
  const proto::LatticeBox box = layers_[tile.layer].boxOf(tile);
  const glm::dvec2 size = box.high - box.low;
  uint32_t level = 0;
  while (level + 1 < squares.levels() && squares.side(level + 1) * kPartsAcross <= std::max(size.x, size.y)) ++level;
  const glm::dvec2 last(squares.columns(level) - 1, squares.rows(level) - 1);
  const double side = squares.side(level);
  const glm::uvec2 low(glm::clamp(glm::floor(box.low / side), glm::dvec2(0), last)),
      high(glm::clamp(glm::floor(box.high / side), glm::dvec2(0), last));
  for (uint32_t j = low.y; j <= high.y; ++j)
    for (uint32_t i = low.x; i <= high.x; ++i) add(box, level, i, j, kMaxSplits, out);
  return true;
}

bool VisibleGround::split(const proto::TilePart& part, std::vector<proto::TilePart>& out) {
  if (part.level == 0 || part.splits_left == 0) return false;
  const GroundSquares& squares = ground_->squares;
  for (uint32_t j = 2 * part.j; j < std::min(2 * part.j + 2, squares.rows(part.level - 1)); ++j)
    for (uint32_t i = 2 * part.i; i < std::min(2 * part.i + 2, squares.columns(part.level - 1)); ++i)
      add(part.box, part.level - 1, i, j, part.splits_left - 1, out);
  return true;
}

void VisibleGround::add(const proto::LatticeBox& within, uint32_t level, uint32_t i, uint32_t j, uint32_t splits_left,
                        std::vector<proto::TilePart>& out) {
  const GroundSquares& squares = ground_->squares;
  const double side = squares.side(level);
  const glm::dvec2 first(i, j), end(i + 1, j + 1);
  proto::LatticeBox box{glm::max(within.low, first * side), glm::min(within.high, end * side)};
  if (i == 0) box.low.x = within.low.x;
  if (j == 0) box.low.y = within.low.y;
  if (i + 1 == squares.columns(level)) box.high.x = within.high.x;
  if (j + 1 == squares.rows(level)) box.high.y = within.high.y;
  if (!(box.low.x < box.high.x && box.low.y < box.high.y)) return;
  const GroundSquares::Square& square = squares.square(level, i, j);
  out.push_back(
      {box, square.lowest_m, square.highest_m, square.min_rise_m, square.largest_rise_m, level, i, j, splits_left});
}

// The part's top is raised by what the tolerance is at its own distance, seen from above as from the side.
bool VisibleGround::isHidden(const proto::TilePart& part) {
  if (horizons_.empty()) return false;
  Horizon& horizon = *horizons_.front();
  const HorizonGrid& grid = *ground_->grid;
  const HorizonGrid::Bounds ground = grid.boundsOf(part.box, part.lowest_m, part.highest_m);
  const double spread_m = horizon.extent() + glm::length(ground.high - ground.low) * grid.metresOfStep(),
               distance_m = glm::length(grid.toScene(ground.low - horizon.begin()));
  if (distance_m < 2 * spread_m) return false;
  const double drop_m = std::fabs(ground.top_m - horizon.eyes().eye.z) + spread_m;
  const double top_m = ground.top_m + tau_per_m_ * (distance_m + spread_m + drop_m * drop_m / (distance_m - spread_m));
  return horizon.hides({ground.low, ground.high, top_m, top_m, glm::dvec2(0)});
}

}  // namespace foreland::server
