#include "lab/allocation_count.h"

#include <malloc.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "base/sanitized.h"

namespace {
std::atomic<uint64_t> allocations{0};
std::atomic<size_t> live_bytes{0};
}  // namespace

#if !FORELAND_SANITIZED
void* operator new(std::size_t size) {
  void* p = std::malloc(size ? size : 1);
  if (p == nullptr) throw std::bad_alloc();
  allocations.fetch_add(1, std::memory_order_relaxed);
  live_bytes.fetch_add(malloc_usable_size(p), std::memory_order_relaxed);
  return p;
}
void operator delete(void* p) noexcept {
  live_bytes.fetch_sub(malloc_usable_size(p), std::memory_order_relaxed);
  std::free(p);
}
void operator delete(void* p, std::size_t) noexcept { operator delete(p); }
#endif

namespace foreland::lab {

uint64_t allocationCount() { return allocations.load(std::memory_order_relaxed); }

size_t liveBytes() { return live_bytes.load(std::memory_order_relaxed); }

}  // namespace foreland::lab
