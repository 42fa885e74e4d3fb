#include "bench/drape/tile_puller.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace foreland::bench {

TilePuller::TilePuller(std::shared_ptr<const terrain::Scene> scene, uint8_t layer, const proto::Lens& lens,
                       const PullOptions& options)
    : scene_(std::move(scene)),
      layer_(layer),
      lens_(lens),
      frame_(scene_->frame()),
      options_(options),
      up_(options.links.up, options.seed),
      down_(options.links.down, options.seed + 1) {}

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
    } else if (requested_.size() < options_.most_requests && requested_.insert(tile.key()).second) {
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

// Whether any part of the box may be: all its corners on the outer side of one plane is out of view.
bool TilePuller::isInView(const proto::TileId& tile, const proto::Pose& pose) const {
  const proto::LatticeBox box = scene_->tiles().layers()[layer_].boxOf(tile);
  const proto::TileBounds bounds = *scene_->tiles().bounds(tile);
  const double tan_y = std::tan(0.5 * lens_.vertical_fov_rad), tan_x = tan_y * lens_.width_px / lens_.height_px;
  std::array<bool, 5> is_out{true, true, true, true, true};
  for (const double x : {box.low.x, box.high.x})
    for (const double y : {box.low.y, box.high.y})
      for (const float h : {bounds.lowest_m, bounds.highest_m}) {
        const glm::dvec3 p = frame_.toScene(proto::LatticePosition{x, y, h}) - pose.eye;
        const double depth = glm::dot(p, pose.forward()), right = glm::dot(p, pose.right()),
                     up = glm::dot(p, pose.up());
        const std::array<bool, 5> out{depth<0, right> depth * tan_x, -right > depth * tan_x, up > depth * tan_y,
                                      -up > depth * tan_y};
        for (size_t i = 0; i < out.size(); ++i) is_out[i] = is_out[i] && out[i];
      }
  return std::none_of(is_out.begin(), is_out.end(), [](bool out) { return out; });
}

}  // namespace foreland::bench
