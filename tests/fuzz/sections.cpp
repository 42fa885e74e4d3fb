// Decodes any bytes as the sections that a client resumes from. The result must be closed sections that can
// be encoded again, or an Error. The first byte selects the grid, and whether objects stand on it.
#include "base/check.h"
#include "proto/codec/section_codec.h"
#include "proto/codec/surface_cut.h"
#include "tests/fuzz/section_grids.h"
#include "tests/fuzz/toy_objects.h"

namespace foreland {
namespace {

void run(ByteSpan bytes) {
  constexpr size_t kMaxNodes = 5000;
  static const proto::ObjectSet none;
  if (bytes.empty()) return;
  const proto::GridTopology& grid = test::sectionGrids()[bytes[0] % test::sectionGrids().size()];
  const proto::ObjectSet& objects = bytes[0] >= 128 ? test::toyObjects() : none;
  const auto sections = proto::decodeSections(grid, objects, bytes.subspan(1), kMaxNodes);
  if (!sections) return;
  CHECK_LE(sections->terrain.slots.size(), kMaxNodes);
  CHECK_TRUE(validate(grid, sections->terrain).ok());
  for (size_t i = 0; i < objects.size(); ++i) {
    proto::SurfaceCut cut(objects.domain(i).topology());
    cut.hold(sections->objects[i]);
    cut.validate();
  }
  Bytes again;
  proto::encodeSections(grid, objects, *sections, again);
  const auto heard = proto::decodeSections(grid, objects, again, kMaxNodes);
  CHECK_TRUE(heard.ok());
  CHECK_TRUE(*heard == *sections);
}

}  // namespace
}  // namespace foreland

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  foreland::run({data, size});
  return 0;
}
