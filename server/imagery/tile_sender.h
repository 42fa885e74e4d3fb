// What one viewer is sent of the scene's tiles, and when: first what the keyframe's view needs, relief before imagery
// and coarse before fine, then what it will need in the next seconds, the nearest first. Nothing is sent twice that the
// viewer holds. One owner (a session). Source: IMAGERY, "Metric" and "When".
#pragma once

#include <span>
#include <unordered_set>
#include <vector>

#include "base/bytes.h"
#include "proto/imagery/tile_memory.h"
#include "proto/imagery/tile_selection.h"
#include "proto/message/message.h"
#include "server/imagery/tile_pace.h"
#include "server/section/hierarchy.h"

namespace foreland::server {

class TileSender {
 public:
  // The size on the screen that texels may have, in pixels, where the data have finer ones.
  static constexpr double kTexel_px = 2;
  // Of one view and layer; the page has so many layers of textures.
  static constexpr size_t kMostSelected = 256;

  struct Statistics {
    uint64_t tiles = 0, bytes = 0;  // sent
  };

  TileSender(const Hierarchy& hierarchy, uint32_t held_bytes);

  // The viewer holds these from an earlier connection. An Error if the scene has no such tiles. Nothing has been sent.
  Status hold(const proto::HeldTiles& held);

  // Chooses what follows a keyframe of index `keyframe`: `views` are those that tiles are needed for, the keyframe's
  // own first. O(tiles needed), about 1 us each.
  void choose(uint32_t keyframe, std::span<const proto::View> views, const proto::ViewRequest& request);
  // The messages that follow the keyframe: what is stated, if it changed, and tiles as the pace allows.
  void take(std::vector<Bytes>& out);

  TilePace& pace() { return pace_; }
  // What the viewer holds once it has read everything sent.
  const proto::TileMemory& held() const { return held_; }
  const Statistics& statistics() const { return statistics_; }

 private:
  void state(uint8_t layer);
  void queueSelected();
  float shownInPlaceOf(const proto::SelectedTile& missing) const;
  Bytes messageOf(const proto::TileId& tile) const;

  const terrain::TileTable& table_;
  proto::FrameTransform frame_;
  proto::TileMemory held_;
  uint64_t most_needed_bytes_;  // half of what the viewer holds, so that what is needed is not dropped for the rest
  TilePace pace_;
  proto::TileStatement statement_, told_;
  std::vector<proto::TileId> waiting_;   // to be sent, in this order
  std::unordered_set<uint64_t> needed_;  // by any of the views
  uint64_t needed_bytes_ = 0;            // of these
  std::vector<proto::SelectedTile> selected_;
  Statistics statistics_;
};

}  // namespace foreland::server
