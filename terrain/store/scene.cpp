#include "terrain/store/scene.h"

#include "terrain/store/mapped_scene.h"

namespace foreland::terrain {

Result<std::shared_ptr<const Scene>> Scene::open(const std::filesystem::path& path) {
  auto scene = MappedScene::open(path);
  if (!scene.ok()) return scene.error();
  return std::shared_ptr<const Scene>(std::move(*scene));
}

int32_t Scene::height(proto::NodeId v) const {
  if (!grid_.isBase(v)) return node(v).height();
  const uint32_t k = grid_.shape().root_log2, x = v.x() >> k, y = v.y() >> k;
  if (grid_.scaleLog2(v) >= k) return corners_[static_cast<size_t>(y) * (grid_.shape().roots_x + 1) + x];
  return centres_[static_cast<size_t>(y) * grid_.shape().roots_x + x];
}

}  // namespace foreland::terrain
