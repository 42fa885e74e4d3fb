// Any bytes as the section that a client presents to go on with: a closed section, which can be said again, or an
// Error.
#include "base/check.h"
#include "proto/section_codec.h"
#include "tests/fuzz/section_grids.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace foreland;
  constexpr size_t kMostNodes = 5000;
  if (size == 0) return 0;
  const proto::GridTopology& grid = test::sectionGrids()[data[0] % test::sectionGrids().size()];
  const auto section = proto::decodeSection(grid, {data + 1, size - 1}, kMostNodes);
  if (!section) return 0;
  CHECK_LE(section->slots.size(), kMostNodes);
  CHECK_TRUE(validate(grid, *section).ok());
  Bytes again;
  proto::encodeSection(grid, *section, again);
  const auto heard = proto::decodeSection(grid, again, kMostNodes);
  CHECK_TRUE(heard.ok());
  CHECK_TRUE(heard->slots == section->slots);
  return 0;
}
