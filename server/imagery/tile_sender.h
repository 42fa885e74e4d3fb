// What one viewer is sent of the scene's tiles, and when: first what the keyframe's view needs and what it will need in
// the next seconds, relief before imagery and what is seen largest before the rest, then what makes the picture better
// for few bytes; until the first view is whole nothing but what it needs. Nothing that ridges hide, and nothing twice
// that the viewer holds. One owner (a session). Source: THEORY section 5, "Metric" and "When".
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "proto/imagery/tile_memory.h"
#include "proto/imagery/tile_selection.h"
#include "proto/message/message.h"
#include "proto/refine/metric/frustum.h"
#include "server/imagery/tile_pace.h"
#include "server/imagery/visible_ground.h"
#include "server/section/hierarchy.h"
#include "terrain/store/distant/chunk_cache.h"

namespace foreland::server {

class TileSender {
 public:
  // The size on the screen that texels may have, in pixels, where the data have finer ones.
  static constexpr double kTexel_px = 2;
  // Finer tiles of imagery are sent as well, if they make the picture better by so much a byte while they are expected
  // to be seen: squared error of luminance (1 is black against white), times pixels and seconds.
  static constexpr double kMinGain = 2.4e-4;
  // Of one view and layer, and with the finer ones.
  static constexpr size_t kMaxSelected = 256, kMaxFiner = 512;
  static constexpr uint32_t kWantEvery = 5, kShortFor = 25;  // keyframes
  static constexpr double kFinestTexel_px = 0.5;             // of a parent; finer tiles than its children are of no use

  struct Statistics {
    uint64_t tiles = 0, bytes = 0;  // sent
  };

  // A view that tiles are needed for, and where the eye may be while it is shown.
  struct Target {
    proto::View view;
    EyeCapsule eyes;
  };

  // Where the camera is expected to be later on, and for how long it is taken to be there.
  struct Dwell {
    proto::Pose pose;
    double seconds;
  };

  // Without `ground` tiles are chosen by their own bounds.
  TileSender(const Hierarchy& hierarchy, std::shared_ptr<const SceneGround> ground, uint32_t held_bytes);

  // The viewer holds these from an earlier connection. An Error if the scene has no such tiles. Nothing has been sent.
  Status hold(const proto::HeldTiles& held);

  // Chooses what follows a keyframe of index `keyframe`, whose own view is the first of `targets`. O(tiles needed),
  // about 1 us each, and 10 us for those that the viewer lacks. What `dwells` see is what finer tiles are worth, in
  // proportion to what they are in the last target.
  void choose(uint32_t keyframe, std::span<const Target> targets, std::span<const Dwell> dwells,
              const proto::ViewRequest& request);
  // What is stated, if it changed. Goes before the keyframe, so that it counts for the mesh that ends there.
  void takeStatement(std::vector<Bytes>& out);
  // The tiles that follow the keyframe, as the pace allows.
  void takeTiles(std::vector<Bytes>& out);
  // Of a scene at a distance: what the last takeTiles() could not take because it is not there, in the order of texels
  // on the screen.
  std::vector<terrain::ChunkCache::Wish> takeLacking() { return std::exchange(lacking_, {}); }

  // Whether tiles had to wait for the link, lately.
  bool isShort() const { return statement_.keyframe < short_until_; }

  TilePace& pace() { return pace_; }
  // What the viewer holds once it has read everything sent.
  const proto::TileMemory& held() const { return held_; }
  const Statistics& statistics() const { return statistics_; }

 private:
  void select(const Target& target, uint8_t layer, double texel_px, size_t most);
  void state(uint8_t layer);
  bool isViewWhole(const proto::ViewRequest& request) const;
  template <class IsQueued>
  void queueSelected(const IsQueued& isQueued);
  void sortWaiting();
  bool isWorthItsBytes(const proto::SelectedTile& tile, const proto::Pose& from) const;
  double secondsOfUse(const proto::TileId& tile, const proto::Pose& from) const;
  std::optional<Bytes> messageOf(const proto::SelectedTile& each);

  const terrain::Scene& scene_;
  const terrain::TileTable& table_;
  std::vector<terrain::ChunkCache::Wish> lacking_;
  proto::FrameTransform frame_;
  proto::TileMemory held_;
  uint64_t max_needed_bytes_;  // half of what the viewer holds, so that what is needed is not dropped for the rest
  TilePace pace_;
  std::optional<VisibleGround> ground_;
  proto::TileStatement statement_, stated_;
  std::vector<proto::SelectedTile> waiting_;  // to be sent, in this order
  // By any of the views: the largest size of their texels, in pixels; none larger than of their parents'.
  std::unordered_map<uint64_t, float> needed_;
  uint64_t needed_bytes_ = 0;  // of these
  struct DwellView {
    proto::Frustum frustum;
    Dwell dwell;
  };
  std::vector<DwellView> dwells_;
  std::vector<proto::SelectedTile> selected_;
  uint32_t short_until_ = 0;     // keyframe
  bool had_first_view_ = false;  // once all that a keyframe's view needs was there
  Statistics statistics_;
};

}  // namespace foreland::server
