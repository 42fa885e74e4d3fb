#include "server/net/memory_return.h"

#include <malloc.h>

#include <algorithm>

namespace foreland::server {

bool MemoryReturn::isDue(size_t viewers, Time now) {
  most_ = std::max(most_, viewers);
  if (4 * viewers > 3 * most_ || most_ == 0 || now - last_ < kMinInterval) return false;
  most_ = viewers;
  last_ = now;
  return true;
}

void MemoryReturn::prepare() {
#ifdef __GLIBC__
  // The least size of a large block. Unless it is set, glibc raises it to that of any large block that is given up.
  constexpr int kLargeBlock = 128 << 10;
  ::mallopt(M_MMAP_THRESHOLD, kLargeBlock);
#endif
}

void MemoryReturn::run() {
#ifdef __GLIBC__
  ::malloc_trim(0);
#endif
}

}  // namespace foreland::server
