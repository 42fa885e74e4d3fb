// The positions of globes in WebAssembly, for client/js/tests/globe_positions.test.mjs.
#include "tests/proto/space/globe_positions.h"

#define FORELAND_EXPORT(name) extern "C" __attribute__((export_name(#name)))

namespace foreland::proto {

FORELAND_EXPORT(hash_of_positions) uint64_t hashOfPositions() { return hashOfGlobePositions(kGlobePositions); }
// That of native code, which a test holds to it.
FORELAND_EXPORT(native_hash) uint64_t nativeHash() { return kHashOfGlobePositions; }

}  // namespace foreland::proto
