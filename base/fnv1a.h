// The 64-bit Fowler-Noll-Vo hash 1a (draft-eastlake-fnv): it names and compares, and secures nothing. Value.
#pragma once

#include <cstdint>
#include <string_view>

namespace foreland {

class Fnv1a {
 public:
  void add(uint8_t byte) { value_ = (value_ ^ byte) * 0x100000001b3ull; }
  void add(std::string_view text) {
    for (const char c : text) add(static_cast<uint8_t>(c));
  }
  // Its eight bytes, the lowest first.
  void addWord(uint64_t word) {
    for (int shift = 0; shift < 64; shift += 8) add(static_cast<uint8_t>(word >> shift));
  }
  uint64_t value() const { return value_; }

 private:
  uint64_t value_ = 0xcbf29ce484222325ull;
};

}  // namespace foreland
