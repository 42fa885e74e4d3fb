// Any bytes as a scene file: opened and readable throughout, its objects too, or an Error.
#include "terrain/objects/placed_objects.h"
#include "tests/fuzz/as_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace foreland;
  test::asFile({data, size}, [](const std::string& path) {
    const auto scene = terrain::Scene::open(path);
    if (!scene) return;
    int64_t sum = 0;
    for (const terrain::NodeRecord& node : (*scene)->nodes()) sum += node.height();
    for (int32_t height : (*scene)->cornerHeights()) sum += height;
    for (int32_t height : (*scene)->centreHeights()) sum += height;
    if (auto objects = terrain::readObjects(*scene))
      for (const auto& model : objects->models)
        for (const proto::SurfaceRecord& node : model->nodes()) sum += node.position.x;
    const volatile int64_t keep = sum;
    static_cast<void>(keep);
  });
  return 0;
}
