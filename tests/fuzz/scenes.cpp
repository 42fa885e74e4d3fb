// Any bytes as a scene file: opened and readable throughout, its objects too, or an Error.
#include <sys/mman.h>
#include <unistd.h>

#include <string>

#include "base/check.h"
#include "terrain/objects/placed_objects.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace foreland;
  const int file = memfd_create("scene", 0);
  CHECK_GE(file, 0);
  CHECK_EQ(write(file, data, size), static_cast<ssize_t>(size));
  if (auto scene = terrain::Scene::open("/proc/self/fd/" + std::to_string(file))) {
    int64_t sum = 0;
    for (const terrain::NodeRecord& node : (*scene)->nodes()) sum += node.height();
    for (int32_t height : (*scene)->cornerHeights()) sum += height;
    for (int32_t height : (*scene)->centreHeights()) sum += height;
    if (auto objects = terrain::readObjects(*scene))
      for (const auto& model : objects->models)
        for (const proto::SurfaceRecord& node : model->nodes()) sum += node.position.x;
    const volatile int64_t keep = sum;
    static_cast<void>(keep);
  }
  close(file);
  return 0;
}
