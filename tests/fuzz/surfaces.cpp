// Opens a changed surface file, or any bytes as one (tests/fuzz/changed_file.h). Everything in it must be readable, or
// the result an Error.
#include "terrain/surface_store/mapped_surface.h"
#include "tests/fuzz/changed_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace foreland;
  auto file = test::fileOf({data, size}, test::soundSurfaces());
  const ByteSpan bytes = file->span();
  const auto surface = terrain::MappedSurface::of(bytes, "fuzzed", std::move(file));
  if (!surface) return 0;
  int64_t sum = 0;
  for (const glm::ivec3& p : (*surface)->basePositions()) sum += p.x;
  for (const proto::SurfaceRecord& node : (*surface)->nodes()) sum += node.position.y;
  for (const auto& moves : {(*surface)->baseMoves(), (*surface)->nodeMoves()})
    for (const glm::ivec3& move : moves) sum += move.z;
  for (terrain::Texel texel : (*surface)->texels()) sum += texel;
  const volatile int64_t keep = sum;
  static_cast<void>(keep);
  return 0;
}
