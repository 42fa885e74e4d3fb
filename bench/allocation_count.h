// Counts heap allocations of the whole program, for benchmarks that claim there are none. Any thread.
#pragma once

#include <cstdint>

namespace foreland::bench {

// Calls of operator new so far; 0 under a sanitizer. Linking this replaces the global operator new.
uint64_t allocationCount();

}  // namespace foreland::bench
