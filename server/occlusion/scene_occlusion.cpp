#include "server/occlusion/scene_occlusion.h"

namespace foreland::server {

Result<std::shared_ptr<const SceneOcclusion>> SceneOcclusion::create(const Hierarchy& hierarchy) {
  SceneOcclusion scene{BlockTops(hierarchy), std::nullopt, nullptr};
  if (HorizonGrid::supports(hierarchy)) {
    scene.grid.emplace(hierarchy);
  } else {
    auto occluder = Occluder::create(hierarchy);
    if (!occluder) return occluder.error();
    scene.occluder = std::move(*occluder);
  }
  return std::make_shared<const SceneOcclusion>(std::move(scene));
}

}  // namespace foreland::server
