// How slacks are kept so that the rounding of their subtractions never makes one too large. Any thread.
#pragma once

#include <cstdint>

namespace foreland::proto {

// A step rounds a slack by at most 2^-24 of it. Slacks are kept 2^-9 short, and all entries are tested anew before 2^15
// steps can use that up.
inline constexpr double kSlackShare = 1 - 0x1p-9;
inline constexpr uint32_t kMaxSteps = 1u << 15;

}  // namespace foreland::proto
