#include "bench/allocation_count.h"

#include <atomic>
#include <cstdlib>
#include <new>

#include "base/sanitized.h"

namespace {
std::atomic<uint64_t> allocations{0};
}

// A sanitizer has its own, and knows what comes from which.
#if !FORELAND_SANITIZED
void* operator new(std::size_t size) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  if (void* p = std::malloc(size ? size : 1)) return p;
  throw std::bad_alloc();
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
#endif

namespace foreland::bench {

uint64_t allocationCount() { return allocations.load(std::memory_order_relaxed); }

}  // namespace foreland::bench
