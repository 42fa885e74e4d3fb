// Any bytes as the sections that a client presents to go on with: closed sections, which can be said again, or an
// Error. First byte: which grid, and whether objects stand on it.
#include "base/check.h"
#include "proto/section_codec.h"
#include "proto/surface_cut.h"
#include "tests/fuzz/section_grids.h"

namespace foreland {
namespace {

// A tetrahedron by either rule.
proto::ObjectSet tetrahedra() {
  std::vector<proto::ObjectModel> models;
  for (const proto::MeshRule rule : {proto::MeshRule::kQuadrisection, proto::MeshRule::kBisection}) {
    proto::ObjectModel model;
    model.shape = {rule, 3, 4, {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}};
    model.base.resize(rule == proto::MeshRule::kBisection ? 8 : 4);
    models.push_back(model);
  }
  return proto::ObjectSet::create(std::move(models), {{.model = 0}, {.model = 1}, {.model = 0}}).value();
}

void run(ByteSpan bytes) {
  constexpr size_t kMostNodes = 5000;
  static const proto::ObjectSet none, some = tetrahedra();
  if (bytes.empty()) return;
  const proto::GridTopology& grid = test::sectionGrids()[bytes[0] % test::sectionGrids().size()];
  const proto::ObjectSet& objects = bytes[0] >= 128 ? some : none;
  const auto sections = proto::decodeSections(grid, objects, bytes.subspan(1), kMostNodes);
  if (!sections) return;
  CHECK_LE(sections->terrain.slots.size(), kMostNodes);
  CHECK_TRUE(validate(grid, sections->terrain).ok());
  for (size_t i = 0; i < objects.size(); ++i) {
    proto::SurfaceCut cut(objects.domain(i).topology());
    cut.hold(sections->objects[i]);
    cut.validate();
  }
  Bytes again;
  proto::encodeSections(grid, objects, *sections, again);
  const auto heard = proto::decodeSections(grid, objects, again, kMostNodes);
  CHECK_TRUE(heard.ok());
  CHECK_TRUE(*heard == *sections);
}

}  // namespace
}  // namespace foreland

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  foreland::run({data, size});
  return 0;
}
