#include "lab/tiles/tile_client.h"

#include <algorithm>

namespace foreland::lab {

TileClient::TileClient(TileTree& tree, const TileOptions& options)
    : tree_(tree),
      options_(options),
      up_(options.links.up, options.seed),
      down_(options.links.down, options.seed + 1) {}

Result<TileClient::Frame> TileClient::frame(Time now, const proto::Pose& pose) {
  ++frame_;
  if (Status s = receive(now); !s.ok()) return s.error();
  Frame frame{.is_complete = true};
  wanted_.clear();
  select({}, pose, frame);
  request(now);
  for (const TileId& tile : frame.drawn) frame.triangles += tree_.triangles(tile);
  frame.jump_px = jumpFrom(shown_, frame.drawn, pose);
  shown_ = frame.drawn;
  trim();
  return frame;
}

// Adds what is drawn of a tile; false if nothing of it can be. A tile stays until all its children in view can be drawn
// (CesiumJS: QuadtreePrimitive.visitTile). Ancestors are wanted, too (preloadAncestors), siblings out of view not.
bool TileClient::select(const TileId& tile, const proto::Pose& pose, Frame& frame) {
  use(tile);
  const bool is_loaded = loaded_.contains(tile);
  const std::vector<TileId> children = tree_.children(tile);
  if (children.empty() || tree_.screenError(tile, pose, options_.lens) <= options_.max_error_px) {
    if (is_loaded) frame.drawn.push_back(tile);
    frame.is_complete = frame.is_complete && is_loaded;
    return is_loaded;
  }
  const size_t before = frame.drawn.size();
  bool can_refine = true;
  for (const TileId& child : children)
    if (tree_.isInView(child, pose, options_.lens)) can_refine = select(child, pose, frame) && can_refine;
  if (can_refine) return true;
  frame.drawn.resize(before);
  frame.is_complete = false;
  if (is_loaded) frame.drawn.push_back(tile);
  return is_loaded;
}

void TileClient::use(const TileId& tile) {
  const auto loaded = loaded_.find(tile);
  if (loaded != loaded_.end())
    loaded->second = frame_;
  else if (!requested_.contains(tile))
    wanted_.insert(tile);
}

Status TileClient::receive(Time now) {
  while (up_.nextArrival() && *up_.nextArrival() <= now) {
    const Time at = *up_.nextArrival();
    (void)up_.receive();
    const TileId tile = asked_.front();
    asked_.pop_front();
    const auto bytes = tree_.bytes(tile, options_.codec);
    if (!bytes) return bytes.error();
    down_.send(Bytes(*bytes), at);
    answered_.push_back(tile);
  }
  while (down_.nextArrival() && *down_.nextArrival() <= now) {
    const size_t bytes = down_.receive().size();
    const TileId tile = answered_.front();
    answered_.pop_front();
    requested_.erase(tile);
    loaded_[tile] = frame_;
    statistics_.bytes += bytes;
    if (received_.insert(tile).second) statistics_.bytes_once += bytes;
  }
  return {};
}

void TileClient::request(Time now) {
  for (const TileId& tile : wanted_) {
    if (requested_.size() >= options_.max_requests) return;
    requested_.insert(tile);
    asked_.push_back(tile);
    up_.send(Bytes(1), now);
    ++statistics_.requests;
  }
}

// Those that were not used for longest go first; none that this frame used.
void TileClient::trim() {
  if (loaded_.size() <= options_.cache_tiles) return;
  std::vector<std::pair<uint64_t, TileId>> unused;
  for (const auto& [tile, used] : loaded_)
    if (used < frame_) unused.emplace_back(used, tile);
  std::sort(unused.begin(), unused.end());
  for (size_t i = 0; i < unused.size() && loaded_.size() > options_.cache_tiles; ++i) loaded_.erase(unused[i].second);
}

double TileClient::jumpFrom(const std::vector<TileId>& before, const std::vector<TileId>& after,
                            const proto::Pose& pose) const {
  const std::set<TileId> old(before.begin(), before.end()), now(after.begin(), after.end());
  double most = 0;
  for (const TileId& tile : after)  // finer than before
    for (TileId above = tile; !old.contains(tile) && above.level > 0;)
      if (above = above.parent(); old.contains(above))
        most = std::max(most, tree_.jump(tile, above, pose, options_.lens));
  for (const TileId& tile : before)  // coarser
    for (TileId above = tile; !now.contains(tile) && above.level > 0;)
      if (above = above.parent(); now.contains(above))
        most = std::max(most, tree_.jump(tile, above, pose, options_.lens));
  return most;
}

}  // namespace foreland::lab
