// Opens a changed scene file, or any bytes as one (tests/fuzz/changed_file.h). Everything in it, objects and tiles
// included, must be readable, or the result an Error.
#include <string>
#include <vector>

#include "base/check.h"
#include "proto/imagery/relief_codec.h"
#include "terrain/objects/placed_objects.h"
#include "terrain/store/mapped_scene.h"
#include "tests/fuzz/changed_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace foreland;
  auto file = test::fileOf({data, size}, test::soundScenes());
  const ByteSpan bytes = file->span();
  const auto mapped = terrain::MappedScene::of(bytes, "fuzzed", std::move(file));
  if (!mapped) return 0;
  const std::shared_ptr<const terrain::Scene> scene = *mapped;
  int64_t sum = 0;
  for (const terrain::NodeRecord& node : scene->records()) sum += node.height();
  for (int32_t height : scene->cornerHeights()) sum += height;
  for (int32_t height : scene->centreHeights()) sum += height;
  if (auto objects = terrain::readObjects(scene))
    for (const auto& model : objects->models)
      for (const proto::SurfaceRecord& node : model->nodes()) sum += node.position.x;
  std::vector<int32_t> steps(proto::kTileTexels);
  for (uint8_t layer = 0; layer < scene->tiles().layers().size(); ++layer)
    scene->tiles().forEach(layer, [&](const proto::TileId& tile) {
      const auto bounds = scene->tiles().bounds(tile);
      const ByteSpan coded = scene->tiles().bytes(tile);
      CHECK_EQ(bounds.has_value(), !coded.empty());
      if (bounds && proto::decodeRelief(coded, steps).ok()) sum += steps.back();
    });
  scene->tiles().check([&](const std::string& what) { sum += static_cast<int64_t>(what.size()); });
  const volatile int64_t keep = sum;
  static_cast<void>(keep);
  return 0;
}
