#include "server/occlusion/scene_occlusion.h"

#include <utility>

namespace foreland::server {

namespace {

Result<std::shared_ptr<const SceneOcclusion>> ofGlobe(const Hierarchy& hierarchy, GlobeGrids::Building building) {
  if (!hierarchy.epochs().epochs().empty())
    return Error{
        ErrorCode::kUnsupported,
        "occlusion: what ridges hide is not known of globes whose ground moves; serve it with --occlusion off"};
  SceneOcclusion scene{BlockTops(), nullptr, nullptr};
  scene.globe = std::make_shared<SceneOcclusion::Globe>(hierarchy, building);
  return std::make_shared<const SceneOcclusion>(std::move(scene));
}

}  // namespace

Result<std::shared_ptr<const SceneOcclusion>> SceneOcclusion::create(const Hierarchy& hierarchy,
                                                                     std::shared_ptr<const HorizonGrid> grid,
                                                                     GlobeGrids::Building building) {
  if (hierarchy.grid().isCube()) return ofGlobe(hierarchy, building);
  SceneOcclusion scene{BlockTops(hierarchy), std::move(grid), nullptr};
  if (!scene.grid) scene.grid = HorizonGrid::of(hierarchy);
  if (!scene.grid && hierarchy.scene().isSparse())
    return Error{ErrorCode::kUnsupported,
                 "occlusion: what ridges hide is not known of scenes that are fine in places only and extend far over "
                 "the earth; serve it with --occlusion off"};
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
