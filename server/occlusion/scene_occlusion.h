// What all viewers of a scene share to find out what its ridges hide. Immutable; any thread.
#pragma once

#include <memory>

#include "server/occlusion/horizon/block_tops.h"
#include "server/occlusion/horizon/horizon_grid.h"
#include "server/occlusion/objects/object_solids.h"
#include "server/occlusion/occluder.h"

namespace foreland::server {

struct SceneOcclusion {
  BlockTops tops;
  std::shared_ptr<const HorizonGrid> grid;   // null if the scene extends too far over the earth for one
  std::shared_ptr<const Occluder> occluder;  // of such a scene; null if there is a grid

  std::shared_ptr<const ObjectSolids> objects{};  // null if the scene has none

  // As Occluder::create; takes `grid` if there is one already. O(samples).
  static Result<std::shared_ptr<const SceneOcclusion>> create(const Hierarchy& hierarchy,
                                                              std::shared_ptr<const HorizonGrid> grid = nullptr);
  size_t bytes() const {
    return tops.bytes() + (grid ? grid->bytes() : 0) + (occluder ? occluder->bytes() : 0) +
           (objects ? objects->bytes() : 0);
  }
};

}  // namespace foreland::server
