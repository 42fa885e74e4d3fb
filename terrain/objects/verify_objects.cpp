#include "terrain/objects/placed_objects.h"

namespace foreland::terrain {

Result<ObjectsReport> verifyObjects(const std::filesystem::path& path, unsigned threads) {
  const auto scene = Scene::open(path);
  if (!scene.ok()) return scene.error();
  const auto objects = readObjects(*scene);
  if (!objects.ok()) return Error{objects.error().code, path.string() + ": " + objects.error().message};
  ObjectsReport report;
  report.objects = objects->set.size();
  for (const auto& model : objects->models) report.models.push_back(verifySurface(*model, threads));
  return report;
}

}  // namespace foreland::terrain
