#include "terrain/store/file/checksum.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace foreland::terrain {

uint64_t xxh64(ByteSpan bytes, uint64_t seed) { return XXH64(bytes.data(), bytes.size(), seed); }

}  // namespace foreland::terrain
