#include "lab/drape/tile_puller.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

namespace foreland::lab {

TilePuller::TilePuller(std::shared_ptr<const terrain::Scene> scene, uint8_t layer, const proto::Lens& lens,
                       const PullOptions& options)
    : scene_(std::move(scene)),
      layer_(layer),
      lens_(lens),
      frame_(scene_->frame()),
      options_(options),
      up_(options.links.up, options.seed),
      down_(options.links.down, options.seed + 1) {
  const proto::Frame& frame = frame_.frame();
  if (frame.kind != proto::FrameKind::kGeographic) return;
  const auto pole = [&](double sign) { return frame_.toScene(proto::Geodetic{sign * std::numbers::pi / 2, 0, 0}); };
  const double lowest_m = scene_->heightRange().lowest * frame.height_quantum_m;
  earth_ = Earth{0.5 * (pole(1) + pole(-1)), glm::normalize(pole(1) - pole(-1)), 1 / (1 - frame.flattening),
                 frame.semi_major_m + std::min(0.0, lowest_m)};
}

void TilePuller::frame(Time now, const proto::Pose& pose) {
  receive(now);
  const proto::TileLayer& layer = scene_->tiles().layers()[layer_];
  needed_.clear();
  need({layer_, static_cast<uint8_t>(layer.levels() - 1), 0, 0}, pose);
  std::sort(needed_.begin(), needed_.end(), [](const proto::TileId& a, const proto::TileId& b) {
    return a.level != b.level ? a.level > b.level : a.key() < b.key();
  });
  drawn_.clear();
  for (const proto::TileId& tile : needed_) {
    if (loaded_.contains(tile.key())) {
      drawn_[tile.key()] = 0;
    } else if (requested_.size() < options_.max_requests && requested_.insert(tile.key()).second) {
      asked_.push_back(tile);
      up_.send(Bytes(1), now);
    }
  }
}

void TilePuller::receive(Time now) {
  while (up_.nextArrival() && *up_.nextArrival() <= now) {
    const Time at = *up_.nextArrival();
    (void)up_.receive();
    answered_.push_back(asked_.front());
    asked_.pop_front();
    down_.send(Bytes(scene_->tiles().bytes(answered_.back()).size()), at);
  }
  while (down_.nextArrival() && *down_.nextArrival() <= now) {
    bytes_ += down_.receive().size();
    requested_.erase(answered_.front().key());
    loaded_.insert(answered_.front().key());
    answered_.pop_front();
  }
}

// A tile, and the finer ones that the rule wants.
void TilePuller::need(const proto::TileId& tile, const proto::Pose& pose) {
  const proto::TileLayer& layer = scene_->tiles().layers()[layer_];
  if (!layer.has(tile) || !scene_->tiles().bounds(tile) || !isInView(tile, pose)) return;
  needed_.push_back(tile);
  if (tile.level == 0 || texelOnScreen(tile, pose) <= options_.texel_px) return;
  for (uint32_t k = 0; k < 4; ++k) need(tile.child(k), pose);
}

double TilePuller::texelOnScreen(const proto::TileId& tile, const proto::Pose& pose) const {
  const proto::TileLayer& layer = scene_->tiles().layers()[layer_];
  const proto::LatticeBox box = layer.boxOf(tile);
  const proto::TileBounds bounds = *scene_->tiles().bounds(tile);
  const proto::LatticePosition eye = frame_.toLattice(pose.eye);
  const double x = std::clamp(eye.x, box.low.x, box.high.x), y = std::clamp(eye.y, box.low.y, box.high.y);
  const double h = std::clamp<double>(eye.height_m, bounds.lowest_m, bounds.highest_m);
  const glm::dvec3 nearest = frame_.toScene(proto::LatticePosition{x, y, h});
  const double distance = std::max(0.1, glm::distance(pose.eye, nearest));
  const double texel_m =
      layer.texelAt(tile.level) * glm::distance(nearest, frame_.toScene(proto::LatticePosition{x, y + 1, h}));
  const double size_px = texel_m * lens_.focalPx() / distance;
  if (options_.rule == TileRule::kDistance) return size_px;
  return size_px * std::sqrt(std::clamp((eye.height_m - h) / distance, 0.05, 1.0));
}

// Whether any part of it may be: a cell all of whose corners are on the outer side of one plane, or behind the earth,
// is not.
bool TilePuller::isInView(const proto::TileId& tile, const proto::Pose& pose) {
  const double tan_y = std::tan(0.5 * lens_.vertical_fov_rad), tan_x = tan_y * lens_.width_px / lens_.height_px;
  const glm::dvec3 eye = scaled(pose.eye);
  const auto isCellInView = [&](const Cell& cell) {
    const auto isBehind = [&](const glm::dvec3& corner) { return isBehindEarth(scaled(corner), eye); };
    if (earth_ && std::all_of(cell.begin(), cell.end(), isBehind)) return false;
    std::array<bool, 5> is_out{true, true, true, true, true};
    for (const glm::dvec3& corner : cell) {
      const glm::dvec3 p = corner - pose.eye;
      const double depth = glm::dot(p, pose.forward()), right = glm::dot(p, pose.right()), up = glm::dot(p, pose.up());
      const std::array<bool, 5> out{depth<0, right> depth * tan_x, -right > depth * tan_x, up > depth * tan_y,
                                    -up > depth * tan_y};
      for (size_t i = 0; i < out.size(); ++i) is_out[i] = is_out[i] && out[i];
    }
    return std::none_of(is_out.begin(), is_out.end(), [](bool out) { return out; });
  };
  const std::vector<Cell>& cells = cellsOf(tile);
  return std::any_of(cells.begin(), cells.end(), isCellInView);
}

// Of a tile in a plane frame the only one is its box. On the earth there are as many as leave little of a bend in each,
// raised by what the ground between the corners rises above the plane through them.
const std::vector<TilePuller::Cell>& TilePuller::cellsOf(const proto::TileId& tile) {
  constexpr double kMax_rad = 0.06;
  std::vector<Cell>& cells = cells_[tile.key()];
  if (!cells.empty()) return cells;
  const proto::LatticeBox box = scene_->tiles().layers()[layer_].boxOf(tile);
  const proto::TileBounds bounds = *scene_->tiles().bounds(tile);
  const proto::Frame& frame = frame_.frame();
  const glm::dvec2 size = box.high - box.low;
  glm::dvec2 count(1), size_rad(0);
  if (earth_) {
    size_rad = size * glm::dvec2(frame.longitude_step_rad, frame.latitude_step_rad);
    count = glm::max(glm::ceil(size_rad / kMax_rad), glm::dvec2(1));
  }
  const double raised_m = frame.semi_major_m * (1 / std::cos(0.5 * glm::length(size_rad / count)) - 1);
  for (double j = 0; j < count.y; ++j)
    for (double i = 0; i < count.x; ++i) {
      Cell& cell = cells.emplace_back();
      for (size_t k = 0; k < cell.size(); ++k) {
        const glm::dvec2 at = box.low + size / count * glm::dvec2(i + double(k % 2), j + double(k / 2 % 2));
        cell[k] =
            frame_.toScene(proto::LatticePosition{at.x, at.y, k < 4 ? bounds.lowest_m : bounds.highest_m + raised_m});
      }
    }
  return cells;
}

// From the middle of the earth, in units in which the lowest ground is a sphere of radius 1.
glm::dvec3 TilePuller::scaled(const glm::dvec3& p) const {
  if (!earth_) return p;
  const glm::dvec3 d = p - earth_->middle;
  return (d + (earth_->stretch - 1) * glm::dot(d, earth_->axis) * earth_->axis) / earth_->radius_m;
}

// Source: K. Ring, "Horizon Culling", which CesiumJS uses: beyond the plane of the horizon, within the cone through it.
bool TilePuller::isBehindEarth(const glm::dvec3& p, const glm::dvec3& eye) {
  const glm::dvec3 to = p - eye;
  const double horizon = glm::dot(eye, eye) - 1, along = -glm::dot(to, eye);
  return horizon > 0 && along > horizon && along * along > horizon * glm::dot(to, to);
}

}  // namespace foreland::lab
