// A viewer that pulls tiles as CesiumJS does, in virtual time over a simulated link. Its assumptions, in the rival's
// favour where the original leaves a choice: no bytes are counted for headers, the server answers at once, decoding
// takes no time; skirts and edges cost nothing. One owner; deterministic.
#pragma once

#include <deque>
#include <map>
#include <set>
#include <vector>

#include "lab/tiles/tile_tree.h"
#include "sim/link_models.h"

namespace foreland::lab {

struct TileOptions {
  proto::Lens lens{};
  double max_error_px = 2;   // CesiumJS: maximumScreenSpaceError
  size_t cache_tiles = 100;  // CesiumJS: tileCacheSize, beside what is in use
  size_t max_requests = 18;  // CesiumJS: RequestScheduler.maximumRequestsPerServer
  TileCodec codec = TileCodec::kQuantizedMesh;
  sim::LinkPair links{};
  uint64_t seed = 1;
};

struct TileStatistics {
  uint64_t bytes = 0, requests = 0;
  uint64_t bytes_once = 0;  // of different tiles: as if whatever was ever received were kept
};

class TileClient {
 public:
  // `tree` outlives the client.
  TileClient(TileTree& tree, const TileOptions& options);

  struct Frame {
    std::vector<TileId> drawn{};
    bool is_complete = false;  // everything in view is as fine as was asked for
    double jump_px = 0;        // since the frame before
    size_t triangles = 0;
  };
  // An Error if a tile cannot be coded. Times do not decrease.
  Result<Frame> frame(Time now, const proto::Pose& pose);
  const TileStatistics& statistics() const { return statistics_; }

 private:
  bool select(const TileId& tile, const proto::Pose& pose, Frame& frame);
  void use(const TileId& tile);
  Status receive(Time now);
  void request(Time now);
  void trim();
  double jumpFrom(const std::vector<TileId>& before, const std::vector<TileId>& after, const proto::Pose& pose) const;

  TileTree& tree_;
  TileOptions options_;
  sim::Link up_, down_;
  std::deque<TileId> asked_, answered_;  // on their way up, and down
  std::set<TileId> requested_, received_;
  std::map<TileId, uint64_t> loaded_;  // and the frame that used it last
  std::set<TileId> wanted_;            // in this frame, coarse ones first
  std::vector<TileId> shown_;
  uint64_t frame_ = 0;
  TileStatistics statistics_;
};

}  // namespace foreland::lab
