// Any bytes as a surface file: opened and readable throughout, or an Error.
#include "terrain/surface_store/mapped_surface.h"
#include "tests/fuzz/as_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace foreland;
  test::asFile({data, size}, [](const std::string& path) {
    const auto surface = terrain::MappedSurface::open(path);
    if (!surface) return;
    int64_t sum = 0;
    for (const glm::ivec3& p : (*surface)->basePositions()) sum += p.x;
    for (const proto::SurfaceRecord& node : (*surface)->nodes()) sum += node.position.y;
    for (terrain::Texel texel : (*surface)->texels()) sum += texel;
    const volatile int64_t keep = sum;
    static_cast<void>(keep);
  });
  return 0;
}
