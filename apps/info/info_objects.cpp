#include "apps/info/info_objects.h"

#include <cinttypes>
#include <cstdio>

#include "apps/info/info_surface.h"

namespace foreland::apps {

using nlohmann::ordered_json;

ordered_json describeObjects(const terrain::PlacedObjects& objects) {
  std::vector<uint64_t> placed(objects.models.size(), 0);
  for (const proto::ObjectPlacement& p : objects.set.placements()) ++placed[p.model];
  ordered_json models = ordered_json::array();
  for (size_t i = 0; i < objects.models.size(); ++i) {
    ordered_json model = describeSurface(*objects.models[i]);
    model["placed"] = placed[i];
    models.push_back(std::move(model));
  }
  return {{"count", objects.set.size()}, {"models", std::move(models)}};
}

void printObjects(const terrain::PlacedObjects& objects) {
  if (objects.set.size() == 0) return;
  const ordered_json about = describeObjects(objects);
  const size_t models = objects.models.size();
  std::printf("objects    %zu of %zu %s\n", objects.set.size(), models, models == 1 ? "model" : "models");
  for (size_t i = 0; i < models; ++i) {
    const ordered_json& m = about["models"][i];
    std::printf(
        "  model    %s: %" PRIu64 " placed; %" PRIu64 " base triangles, %s, %d levels, %" PRIu64 " triangles in all\n",
        m["title"].get<std::string>().c_str(), m["placed"].get<uint64_t>(), m["base"]["triangles"].get<uint64_t>(),
        m["rule"].get<std::string>().c_str(), m["levels"].get<int>(), m["full_triangles"].get<uint64_t>());
    std::printf("    solids %s\n", solidsText(*objects.models[i]).c_str());
  }
}

}  // namespace foreland::apps
