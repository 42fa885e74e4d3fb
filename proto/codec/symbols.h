// Numbers coded by decisions that have learnt (range_coder.h). One owner; any thread; portable to WebAssembly.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>

#include "proto/codec/range_coder.h"

namespace foreland::proto {

// Of a signed number: how many bits it has, its sign, its first bits.
struct NumberModel {
  std::array<AdaptiveBit, 16> exponent;
  std::array<AdaptiveBit, 4> sign;
  std::array<std::array<AdaptiveBit, 4>, 8> mantissa;
};
// Of numbers with 15 bits or more: whether there is another.
using EscapeModel = std::array<AdaptiveBit, 32>;

// Numbers coded with a model; the same code reads and writes. In an encoder `value` is what is coded and returned.
template <class Coder>
class Symbols {
 public:
  Symbols(Coder& coder, EscapeModel& escape) : coder_(coder), escape_(escape) {}

  // 0 .. 2^kBits - 1, as a tree of decisions.
  template <int kBits, size_t kSize>
  uint32_t tree(std::array<AdaptiveBit, kSize>& nodes, uint32_t value) {
    static_assert(kSize >= 1u << kBits);
    uint32_t at = 1;
    for (int i = kBits - 1; i >= 0; --i) at = 2 * at + (coder_.code(nodes[at], value >> i & 1) ? 1 : 0);
    return at - (1u << kBits);
  }
  // The same, with the last value saying that eight bits follow.
  template <int kBits, size_t kSize>
  uint32_t treeOrByte(std::array<AdaptiveBit, kSize>& nodes, uint32_t value) {
    constexpr uint32_t kLast = (1u << kBits) - 1;
    const uint32_t got = tree<kBits>(nodes, std::min(value, kLast));
    return got < kLast ? got : kLast + coder_.codeEvenly(value - kLast, 8);
  }

  // A signed number; the caller's `sign_context` (0 to 3) chooses the model of its sign.
  int32_t number(NumberModel& n, size_t sign_context, int32_t value) {
    const uint32_t magnitude = static_cast<uint32_t>(std::abs(value));
    const int width = static_cast<int>(std::bit_width(magnitude));
    int bits = static_cast<int>(tree<4>(n.exponent, static_cast<uint32_t>(std::min(width, 15))));
    if (bits == 15)
      while (bits < 31 && coder_.code(escape_[static_cast<size_t>(bits)], width > bits)) ++bits;
    if (bits == 0) return 0;
    const bool negative = coder_.code(n.sign[sign_context], value < 0);
    const uint32_t got = mantissa(n.mantissa[static_cast<size_t>(std::min(bits, 7))], bits - 1, magnitude);
    return negative ? -static_cast<int32_t>(got) : static_cast<int32_t>(got);
  }

 private:
  // A leading one and `left` bits, of which the first two have contexts.
  uint32_t mantissa(std::array<AdaptiveBit, 4>& contexts, int left, uint32_t magnitude) {
    uint32_t value = 1;
    for (size_t at = 1; left > 0 && at < 4; --left) {
      const bool one = coder_.code(contexts[at], magnitude >> (left - 1) & 1);
      value = 2 * value + (one ? 1 : 0);
      at = 2 * at + (one ? 1 : 0);
    }
    while (left > 0) {
      const int take = std::min(left, 12);
      left -= take;
      value = value << take | coder_.codeEvenly(magnitude >> left & ((1u << take) - 1), take);
    }
    return value;
  }

  Coder& coder_;
  EscapeModel& escape_;
};

}  // namespace foreland::proto
