#include "server/section/hierarchy.h"

#include "terrain/objects/placed_objects.h"

namespace foreland::server {

Result<SceneObjects> objectsOf(const std::shared_ptr<const terrain::Scene>& scene) {
  auto placed = terrain::readObjects(scene);
  if (!placed.ok()) return placed.error();
  SceneObjects objects;
  for (const auto& model : placed->models) {
    objects.nodes.push_back({model->nodes(), model->nodeMoves(), model->movesEach()});
    objects.texels.push_back(model->texels());
  }
  objects.owner =
      std::make_shared<const std::vector<std::shared_ptr<const terrain::MappedSurface>>>(std::move(placed->models));
  objects.set = std::move(placed->set);
  return objects;
}

}  // namespace foreland::server
