// Any bytes as a surface file: opened and readable throughout, or an Error.
#include <sys/mman.h>
#include <unistd.h>

#include <string>

#include "base/check.h"
#include "terrain/surface_store/mapped_surface.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace foreland;
  const int file = memfd_create("surface", 0);
  CHECK_GE(file, 0);
  CHECK_EQ(write(file, data, size), static_cast<ssize_t>(size));
  if (auto surface = terrain::MappedSurface::open("/proc/self/fd/" + std::to_string(file))) {
    int64_t sum = 0;
    for (const glm::ivec3& p : (*surface)->basePositions()) sum += p.x;
    for (const proto::SurfaceRecord& node : (*surface)->nodes()) sum += node.position.y;
    for (terrain::Texel texel : (*surface)->texels()) sum += texel;
    const volatile int64_t keep = sum;
    static_cast<void>(keep);
  }
  close(file);
  return 0;
}
