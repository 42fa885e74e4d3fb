// A set of slots of one page (kPageSlots), by their index in it. Plain data.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

namespace foreland::proto {

struct SlotBits {
  std::array<uint64_t, 4> words{};

  static SlotBits of(uint8_t low) {
    SlotBits one;
    one.set(low);
    return one;
  }

  // Those below `end`, which is at most 256.
  static SlotBits below(uint32_t end) {
    SlotBits first;
    for (uint32_t w = 0; w < 4 && 64 * w < end; ++w)
      first.words[w] = end - 64 * w < 64 ? (uint64_t{1} << (end - 64 * w)) - 1 : ~uint64_t{0};
    return first;
  }

  bool has(uint8_t low) const { return words[low >> 6] >> (low & 63) & 1; }
  void set(uint8_t low) { words[low >> 6] |= uint64_t{1} << (low & 63); }
  // Sets it if `value`, without a branch.
  void add(uint8_t low, bool value) { words[low >> 6] |= static_cast<uint64_t>(value) << (low & 63); }
  void clear(uint8_t low) { words[low >> 6] &= ~(uint64_t{1} << (low & 63)); }
  bool any() const { return (words[0] | words[1] | words[2] | words[3]) != 0; }

  uint32_t count() const {
    uint32_t count = 0;
    for (uint64_t word : words) count += static_cast<uint32_t>(std::popcount(word));
    return count;
  }
  // How many stand before `low`. Without branches.
  uint32_t countBefore(uint8_t low) const {
    const uint32_t at = low >> 6;
    int count = std::popcount(words[at] & ((uint64_t{1} << (low & 63)) - 1));
    for (uint32_t w = 0; w < 3; ++w) count += std::popcount(words[w] & (0 - static_cast<uint64_t>(w < at)));
    return static_cast<uint32_t>(count);
  }

  // Calls visit(low) for each, ascending. The set may change meanwhile; what is visited does not.
  template <class Visit>
  void forEach(const Visit& visit) const {
    const std::array<uint64_t, 4> all = words;
    for (uint32_t w = 0; w < 4; ++w)
      for (uint64_t bits = all[w]; bits != 0; bits &= bits - 1)
        visit(static_cast<uint8_t>(w << 6 | static_cast<uint32_t>(std::countr_zero(bits))));
  }

  // The same, descending.
  template <class Visit>
  void forEachDescending(const Visit& visit) const {
    const std::array<uint64_t, 4> all = words;
    for (uint32_t w = 4; w-- > 0;)
      for (uint64_t bits = all[w]; bits != 0;) {
        const uint32_t top = 63 - static_cast<uint32_t>(std::countl_zero(bits));
        bits ^= uint64_t{1} << top;
        visit(static_cast<uint8_t>(w << 6 | top));
      }
  }
  // Calls visit(low, how many of `others` stand before it) for each, ascending.
  template <class Visit>
  void forEachRanked(const SlotBits& others, const Visit& visit) const {
    uint32_t before = 0;
    for (uint32_t w = 0; w < 4; ++w) {
      for (uint64_t bits = words[w]; bits != 0; bits &= bits - 1) {
        const uint64_t lower = ~bits & (bits - 1);  // below the lowest
        visit(static_cast<uint8_t>(w << 6 | static_cast<uint32_t>(std::countr_zero(bits))),
              before + static_cast<uint32_t>(std::popcount(others.words[w] & lower)));
      }
      before += static_cast<uint32_t>(std::popcount(others.words[w]));
    }
  }

  friend SlotBits operator|(const SlotBits& a, const SlotBits& b) {
    return {{a.words[0] | b.words[0], a.words[1] | b.words[1], a.words[2] | b.words[2], a.words[3] | b.words[3]}};
  }
  friend SlotBits operator&(const SlotBits& a, const SlotBits& b) {
    return {{a.words[0] & b.words[0], a.words[1] & b.words[1], a.words[2] & b.words[2], a.words[3] & b.words[3]}};
  }
  // Those of a that are not in b.
  friend SlotBits operator-(const SlotBits& a, const SlotBits& b) {
    return {{a.words[0] & ~b.words[0], a.words[1] & ~b.words[1], a.words[2] & ~b.words[2], a.words[3] & ~b.words[3]}};
  }
  bool operator==(const SlotBits&) const = default;
};

}  // namespace foreland::proto
