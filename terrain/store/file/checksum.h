// XXH64 (Yann Collet's xxHash, header-only) over bytes: the scene file's block checksums and content id. Not
// cryptographic: it detects damage, not forgery. Pure; any thread.
#pragma once

#include <cstdint>

#include "base/bytes.h"

namespace foreland::terrain {

[[nodiscard]] uint64_t xxh64(ByteSpan bytes, uint64_t seed = 0);

}  // namespace foreland::terrain
