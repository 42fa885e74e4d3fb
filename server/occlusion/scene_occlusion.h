// What all viewers of a scene share to find out what its ridges hide. Immutable, but for the grids of a globe, which
// come and go with viewers; any thread.
#pragma once

#include <memory>

#include "server/occlusion/horizon/block_tops.h"
#include "server/occlusion/horizon/globe_grids.h"
#include "server/occlusion/horizon/globe_squares.h"
#include "server/occlusion/horizon/horizon_grid.h"
#include "server/occlusion/objects/object_solids.h"
#include "server/occlusion/occluder.h"

namespace foreland::server {

struct SceneOcclusion {
  BlockTops tops;                            // of nothing over globes
  std::shared_ptr<const HorizonGrid> grid;   // null if the scene extends too far over the earth for one, and of globes
  std::shared_ptr<const Occluder> occluder;  // of such a scene; null if there is a grid

  std::shared_ptr<const ObjectSolids> objects{};  // null if the scene has none

  // Of a globe instead of all of these: its squares, and grids about where viewers are.
  struct Globe {
    GlobeSquares squares;
    GlobeGrids grids;
    Globe(const Hierarchy& hierarchy, GlobeGrids::Building building) : squares(hierarchy), grids(hierarchy, building) {}
  };
  std::shared_ptr<Globe> globe{};  // null if the scene is none

  // As Occluder::create; takes `grid` if there is one already. O(samples), but for a globe, of which nothing is made
  // before somebody is there; kUnsupported if its ground moves.
  static Result<std::shared_ptr<const SceneOcclusion>> create(
      const Hierarchy& hierarchy, std::shared_ptr<const HorizonGrid> grid = nullptr,
      GlobeGrids::Building building = GlobeGrids::Building::kByTheCaller);
  size_t bytes() const {
    return tops.bytes() + (grid ? grid->bytes() : 0) + (occluder ? occluder->bytes() : 0) +
           (objects ? objects->bytes() : 0) + (globe ? globe->grids.bytes() : 0);
  }
};

}  // namespace foreland::server
