// Zigzag code: signed numbers as unsigned ones, small ones small (0, -1, 1, -2, ... as 0, 1, 2, 3, ...). Pure.
#pragma once

#include <cstdint>

namespace foreland {

constexpr uint64_t toZigzag(int64_t value) {
  return (static_cast<uint64_t>(value) << 1) ^ static_cast<uint64_t>(value >> 63);
}
constexpr int64_t fromZigzag(uint64_t code) {
  return static_cast<int64_t>(code >> 1) ^ -static_cast<int64_t>(code & 1);
}

}  // namespace foreland
