// The 64-bit Fowler-Noll-Vo hash 1a, of bytes or of larger words: for comparing and naming, not against ill will.
// Value.
#pragma once

#include <cstdint>

namespace foreland {

class Fnv1a {
 public:
  void add(uint64_t word) { value_ = (value_ ^ word) * 1099511628211ull; }
  uint64_t value() const { return value_; }

 private:
  uint64_t value_ = 1469598103934665603ull;
};

}  // namespace foreland
