#include "terrain/store/scene.h"

#include "terrain/store/mapped_scene.h"
#include "terrain/store/stored_heights.h"

namespace foreland::terrain {

using proto::NodeId;

Result<std::shared_ptr<const Scene>> Scene::open(const std::filesystem::path& path, uint64_t page_cache_bytes) {
  auto scene = MappedScene::open(path, page_cache_bytes);
  if (!scene.ok()) return scene.error();
  return std::shared_ptr<const Scene>(std::move(*scene));
}

Status Scene::adoptPages(std::span<const proto::PageBlock> blocks) {
  auto directory = proto::PageDirectory::create(grid_, blocks);
  if (!directory) return directory.error();
  directory_ = std::move(*directory);
  return {};
}

int32_t Scene::height(NodeId v) const {
  const int level = grid_.level(v);
  if (level > 0 && !isSparse() && !supply_) return records_[grid_.slot(v, level)].height();
  return StoredHeights(grid_, directory_, records_, {corners_, centres_}, supply_.get()).at(v);
}

}  // namespace foreland::terrain
