#include "server/occlusion/scene_occlusion.h"

#include <utility>

namespace foreland::server {

Result<std::shared_ptr<const SceneOcclusion>> SceneOcclusion::create(const Hierarchy& hierarchy,
                                                                     std::shared_ptr<const HorizonGrid> grid) {
  if (hierarchy.scene().isSparse())
    return Error{ErrorCode::kUnsupported,
                 "what ridges hide is not known of scenes with sparse levels; serve it with --occlusion off"};
  if (hierarchy.grid().isCube())
    return Error{ErrorCode::kUnsupported, "what ridges hide is not known of globes; serve it with --occlusion off"};
  SceneOcclusion scene{BlockTops(hierarchy), std::move(grid), nullptr};
  if (!scene.grid) scene.grid = HorizonGrid::of(hierarchy);
  if (!scene.grid) {
    auto occluder = Occluder::create(hierarchy);
    if (!occluder) return occluder.error();
    scene.occluder = std::move(*occluder);
  }
  if (!hierarchy.objects().hulls.empty()) {
    auto objects = ObjectSolids::create(hierarchy.objects());
    if (!objects) return objects.error();
    scene.objects = std::move(*objects);
  }
  return std::make_shared<const SceneOcclusion>(std::move(scene));
}

}  // namespace foreland::server
