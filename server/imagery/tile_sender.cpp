#include "server/imagery/tile_sender.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <tuple>
#include <unordered_set>
#include <utility>

namespace foreland::server {

TileSender::TileSender(const Hierarchy& hierarchy, std::shared_ptr<const SceneGround> ground, uint32_t held_bytes)
    : scene_(hierarchy.scene()),
      table_(hierarchy.scene().tiles()),
      frame_(hierarchy.scene().frame()),
      held_(held_bytes),
      max_needed_bytes_(held_bytes / 2) {
  if (ground) ground_.emplace(table_.layers(), std::move(ground), held_);
}

Status TileSender::hold(const proto::HeldTiles& held) {
  for (const proto::TileId& tile : held.tiles) {
    if (tile.layer >= table_.layers().size() || !table_.layers()[tile.layer].has(tile) || !table_.bounds(tile))
      return Error{ErrorCode::kMalformed, "a tile that is held is none of this scene's"};
    held_.add(tile, static_cast<uint32_t>(table_.bytes(tile).size()), [](const proto::TileId&) {});
  }
  return {};
}

void TileSender::choose(uint32_t keyframe, std::span<const Target> targets, std::span<const Dwell> dwells,
                        const proto::ViewRequest& request) {
  waiting_.clear();
  needed_.clear();
  needed_bytes_ = 0;
  statement_.keyframe = keyframe;
  const auto layers = table_.layers();
  for (size_t i = 0; i < targets.size(); ++i) {
    if (ground_) ground_->look(targets[i].eyes, targets[i].view);
    for (size_t at = 0; at < layers.size(); ++at) {
      const auto layer = static_cast<uint8_t>(at);
      if (!request.wants(layers[layer].content)) continue;
      select(targets[i], layer, kTexel_px, kMaxSelected);
      if (i == 0) state(layer);
      queueSelected([](const proto::SelectedTile&) { return true; });
    }
    had_first_view_ = had_first_view_ || isViewWhole(request);
    if (!had_first_view_) break;
  }
  sortWaiting();
  if (!had_first_view_ || keyframe % kWantEvery != 0) return;
  const proto::View& last = targets.back().view;
  dwells_.clear();
  for (const Dwell& dwell : dwells)
    dwells_.push_back({proto::Frustum({dwell.pose, last.lens, last.tau_px}, proto::kNearestGround_m), dwell});
  for (size_t at = 0; at < layers.size(); ++at) {
    const auto layer = static_cast<uint8_t>(at);
    if (layers[layer].content != proto::TileContent::kImagery || !request.wants(layers[layer].content)) continue;
    select(targets.back(), layer, kFinestTexel_px, kMaxFiner);
    queueSelected([&](const proto::SelectedTile& tile) { return isWorthItsBytes(tile, last.pose); });
  }
}

void TileSender::select(const Target& target, uint8_t layer, double texel_px, size_t most) {
  proto::selectTiles(
      table_.layers()[layer], layer, frame_, target.view, texel_px, most,
      [&](const proto::TileId& tile) { return table_.bounds(tile); }, selected_, ground_ ? &*ground_ : nullptr);
}

// The largest texels on the screen are those shown in place of what is missing.
void TileSender::state(uint8_t layer) {
  const auto isHeld = [&](const proto::TileId& tile) { return held_.has(tile); };
  float largest_px = kTexel_px;
  for (const proto::SelectedTile& each : selected_)
    if (!isHeld(each.tile)) largest_px = std::max(largest_px, texelInPlaceOf(each, table_.layers()[layer], isHeld));
  statement_.texel_px[layer] = largest_px;
}

bool TileSender::isViewWhole(const proto::ViewRequest& request) const {
  const auto layers = table_.layers();
  for (size_t layer = 0; layer < layers.size(); ++layer)
    if (request.wants(layers[layer].content) && statement_.texel_px[layer] > kTexel_px) return false;
  return true;
}

template <class IsQueued>
void TileSender::queueSelected(const IsQueued& isQueued) {
  for (const proto::SelectedTile& each : selected_) {
    if (needed_bytes_ > max_needed_bytes_) return;
    if (!isQueued(each) || needed_.contains(each.tile.key())) continue;
    const auto parent = needed_.find(each.tile.parent().key());
    const float texel_px = parent == needed_.end() ? each.texel_px : std::min(each.texel_px, parent->second);
    needed_.emplace(each.tile.key(), texel_px);
    needed_bytes_ += table_.bytes(each.tile).size();
    if (!held_.has(each.tile)) waiting_.push_back({each.tile, texel_px});
  }
}

// On a link that is too slow for all of it whatever is coarsest on the screen is mended first, now or ahead of need;
// and tiles come after their parents.
void TileSender::sortWaiting() {
  std::sort(waiting_.begin(), waiting_.end(), [](const proto::SelectedTile& a, const proto::SelectedTile& b) {
    const auto rank = [](const proto::SelectedTile& s) {
      return std::tuple(s.tile.layer, -s.texel_px, -int{s.tile.level}, s.tile.key());
    };
    return rank(a) < rank(b);
  });
}

// Only if its parent is there, or will be.
bool TileSender::isWorthItsBytes(const proto::SelectedTile& each, const proto::Pose& from) const {
  const double detail = table_.detail(each.tile),
               least = kMinGain * static_cast<double>(table_.bytes(each.tile).size());
  if (detail * detail * each.finer_px * secondsOfUse(each.tile, from) < least) return false;
  const proto::TileId parent = each.tile.parent();
  return held_.has(parent) || needed_.contains(parent.key());
}

// How long a tile is in view, times by how much larger it appears then than from a pose. As if nothing hid it.
double TileSender::secondsOfUse(const proto::TileId& tile, const proto::Pose& from) const {
  const proto::TileBounds bounds = *table_.bounds(tile);
  const proto::LatticeBox box = table_.layers()[tile.layer].boxOf(tile);
  const double height_m = 0.5 * (double{bounds.lowest_m} + bounds.highest_m);
  const glm::dvec3 corner = frame_.toScene(proto::LatticePosition{box.low.x, box.low.y, height_m});
  const glm::dvec3 centre = 0.5 * (corner + frame_.toScene(proto::LatticePosition{box.high.x, box.high.y, height_m}));
  const double radius = glm::distance(centre, corner);
  const auto distanceFrom = [&](const glm::dvec3& eye) { return std::max(glm::distance(centre, eye), radius); };
  const double distance = distanceFrom(from.eye);
  double seconds = 0;
  for (const auto& [frustum, dwell] : dwells_) {
    const glm::dvec3 way = centre - dwell.pose.eye;
    if (frustum.sideDistance(frustum.toView(way.x, way.y, way.z)) < -radius) continue;
    const double nearer = distance / distanceFrom(dwell.pose.eye);
    seconds += dwell.seconds * nearer * nearer;
  }
  return seconds;
}

// Nothing if the tile is not there.
std::optional<Bytes> TileSender::messageOf(const proto::SelectedTile& each) {
  const ByteSpan coded = table_.bytes(each.tile);
  std::optional<Bytes> message;
  const auto encode = [&] {
    message = proto::encode(proto::TileMessage{each.tile, *table_.bounds(each.tile), {coded.begin(), coded.end()}});
  };
  const terrain::PageSupply* supply = scene_.supply();
  if (!supply)
    encode();
  else
    supply->use(static_cast<uint64_t>(coded.data() - supply->cache().file().data()), coded.size(), each.texel_px,
                lacking_, encode);
  return message;
}

void TileSender::takeStatement(std::vector<Bytes>& out) {
  if (statement_.texel_px == stated_.texel_px) return;
  out.push_back(proto::encode(statement_));
  stated_ = statement_;
}

// A tile that is not there waits, and so do those that it is the parent of.
void TileSender::takeTiles(std::vector<Bytes>& out) {
  std::unordered_set<uint64_t> left_out;
  lacking_.clear();
  for (const proto::SelectedTile& each : waiting_) {
    if (!pace_.mayBeSent()) {
      short_until_ = statement_.keyframe + kShortFor;
      break;
    }
    std::optional<Bytes> message;
    if (!left_out.contains(each.tile.parent().key())) message = messageOf(each);
    if (!message) {
      left_out.insert(each.tile.key());
      continue;
    }
    out.push_back(std::move(*message));
    pace_.sent(out.back().size());
    held_.add(each.tile, static_cast<uint32_t>(table_.bytes(each.tile).size()), [](const proto::TileId&) {});
    ++statistics_.tiles;
    statistics_.bytes += out.back().size();
  }
  waiting_.clear();
}

}  // namespace foreland::server
