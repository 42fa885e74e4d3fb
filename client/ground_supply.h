// Brings what a viewer knows of the ground about an eye to another thread, where the camera is: the page's worker has
// the tiles, its drawing thread moves the camera. Where relief is not held at full resolution near the ground, the
// server is asked for exact heights. One owner for either end.
#pragma once

#include <optional>
#include <unordered_set>
#include <vector>

#include "base/bytes.h"
#include "client/ground/ground_heights.h"
#include "client/viewer.h"

namespace foreland::client {

class GroundSupply {
 public:
  // What is news about the ground `reach` samples about an eye (scene frame), for GroundFeed::take. To be called after
  // the first welcome, once a frame; it asks the server, and takes its replies, through `viewer`. At most one tile is
  // decoded: 6 ms as WebAssembly.
  const Bytes& update(Viewer& viewer, const glm::dvec3& eye, double reach);
  // The connection was lost, and with it a reply that has not come.
  void reconnect() { asked_.reset(); }

 private:
  struct Asked {
    uint32_t id;
    GroundPatch patch;
  };
  void putMesh(const Viewer& viewer, const proto::LatticePosition& eye, double reach);
  void putExact(Viewer& viewer, const proto::LatticePosition& eye, double reach);
  void ask(Viewer& viewer, const proto::LatticePosition& eye, double reach);
  void putTiles(const TileStore& tiles, const std::vector<proto::TileId>& wanted);
  bool mayNeedExact(const Viewer& viewer, const proto::LatticePosition& eye, double reach) const;

  uint32_t scene_ = 0;  // TileStore::scene()
  std::unordered_set<uint64_t> sent_;
  std::optional<Asked> asked_;
  GroundPatch exact_;  // that was sent; without heights
  uint32_t exact_rows_ = 0;
  bool is_fine_ = false;  // full relief is held all about the eye
  std::vector<int32_t> steps_;
  Bytes out_;
};

// The other end.
class GroundFeed {
 public:
  // `relief` is the layer of the scene that the update is of. Only for what GroundSupply::update made.
  void take(ByteSpan update, const std::optional<proto::TileLayer>& relief);
  const GroundHeights& heights() const { return heights_; }

 private:
  uint32_t scene_ = 0;
  GroundHeights heights_;
};

// The finest tiles of relief that are held for the ground `reach` samples about a position, the nearest first; of
// coarser levels where `reach` is far.
std::vector<proto::TileId> reliefAbout(const TileStore& tiles, glm::dvec2 at, double reach);

}  // namespace foreland::client
