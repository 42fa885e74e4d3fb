// A viewer that pulls the tiles of a layer by another renderer's rule, in virtual time over a simulated link: each
// frame it asks for what it needs and has not got, coarse tiles first, six at a time, and draws what it has. Its
// assumptions, in the rival's favour where the original leaves a choice: no bytes are counted for headers, the server
// answers at once, decoding takes no time, nothing that came is ever dropped. One owner; deterministic.
#pragma once

#include <array>
#include <deque>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "lab/drape/drape_judge.h"
#include "proto/space/frame.h"
#include "sim/link_models.h"

namespace foreland::lab {

enum class TileRule : uint8_t {
  // CesiumJS: a texel's size over its distance, whatever the angle (QuadtreePrimitive.screenSpaceError, and
  // ImageryLayer, which follows the terrain's error).
  kDistance,
  // MapLibre: tiles of equal area on the screen, if the ground were level (coveringTiles).
  kArea
};

struct PullOptions {
  TileRule rule = TileRule::kDistance;
  double texel_px = 2;
  size_t max_requests = 6;
  sim::LinkPair links{};
  uint64_t seed = 1;
};

class TilePuller {
 public:
  TilePuller(std::shared_ptr<const terrain::Scene> scene, uint8_t layer, const proto::Lens& lens,
             const PullOptions& options);

  // Times do not decrease.
  void frame(Time now, const proto::Pose& pose);
  // What the last frame draws: of what it needs, all that has come.
  const sim::DrawnTiles& drawn() const { return drawn_; }
  uint64_t bytes() const { return bytes_; }

 private:
  void receive(Time now);
  void need(const proto::TileId& tile, const proto::Pose& pose);
  double texelOnScreen(const proto::TileId& tile, const proto::Pose& pose) const;
  bool isInView(const proto::TileId& tile, const proto::Pose& pose);
  using Cell = std::array<glm::dvec3, 8>;  // corners of a box around some of a tile's ground
  const std::vector<Cell>& cellsOf(const proto::TileId& tile);
  glm::dvec3 scaled(const glm::dvec3& p) const;
  static bool isBehindEarth(const glm::dvec3& scaled, const glm::dvec3& scaled_eye);

  std::shared_ptr<const terrain::Scene> scene_;
  uint8_t layer_;
  proto::Lens lens_;
  proto::FrameTransform frame_;
  struct Earth {
    glm::dvec3 middle, axis;
    double stretch, radius_m;  // along the axis, to a sphere; of that, no more than of the lowest ground
  };
  std::optional<Earth> earth_;  // of geographic scenes
  std::unordered_map<uint64_t, std::vector<Cell>> cells_;
  PullOptions options_;
  sim::Link up_, down_;
  std::deque<proto::TileId> asked_, answered_;  // on their way up, and down
  std::unordered_set<uint64_t> requested_, loaded_;
  std::vector<proto::TileId> needed_;  // in this frame
  sim::DrawnTiles drawn_;
  uint64_t bytes_ = 0;
};

}  // namespace foreland::lab
