// The ground of tiles in parts, and which of them ridges hide from a set of eyes: behind a horizon
// (server/occlusion/horizon/horizon.h), whatever of the true ground and of what is drawn of it lies in a part. Exact in
// one direction: what is called hidden is hidden. One owner. Cost: some 20 microseconds for each segment of a horizon
// that is looked at first, then 0.1 us a part, and in geographic frames the places of its corners. Memory: some 100 KiB
// for each of six horizons.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "proto/imagery/tile_memory.h"
#include "proto/imagery/tile_selection.h"
#include "server/imagery/ground_squares.h"
#include "server/occlusion/horizon/horizon.h"
#include "server/view/eye_capsule.h"

namespace foreland::server {

// What all viewers of a scene share. Null if the scene has no grid for horizons, then nothing is hidden.
struct SceneGround {
  GroundSquares squares;
  std::shared_ptr<const HorizonGrid> grid;
};

class VisibleGround final : public proto::TileGround {
 public:
  // Layers and `held` must outlive it. Tiles that are held are not looked at closely, for they cost nothing.
  VisibleGround(std::span<const proto::TileLayer> layers, std::shared_ptr<const SceneGround> ground,
                const proto::TileMemory& held);

  // From these eyes from now on, through a view's lens and with its tolerance: the ground may be drawn lower than it is
  // by as much.
  void look(const EyeCapsule& eyes, const proto::View& view);

  bool parts(const proto::TileId& tile, std::vector<proto::TilePart>& out) override;
  bool split(const proto::TilePart& part, std::vector<proto::TilePart>& out) override;
  bool isHidden(const proto::TilePart& part) override;

 private:
  void add(const proto::LatticeBox& within, uint32_t level, uint32_t i, uint32_t j, uint32_t splits_left,
           std::vector<proto::TilePart>& out);
  std::span<const proto::TileLayer> layers_;
  std::shared_ptr<const SceneGround> ground_;
  const proto::TileMemory& held_;
  std::vector<std::unique_ptr<Horizon>> horizons_;  // the last one used first; none without a grid
  double tau_per_m_ = 0;                            // the tolerance, as metres at a distance of one
};

}  // namespace foreland::server
