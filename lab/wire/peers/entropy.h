// The floor of codecs that know no neighbours. Pure; any thread.
#pragma once

#include <cstdint>
#include <span>

namespace foreland::lab {

// Order-0 (Shannon) entropy in bits per value: what the best code with one fixed word per value would take, the table
// of words not counted. 0 for no values. O(n log n).
double orderZeroEntropyBits(std::span<const int32_t> values);

}  // namespace foreland::lab
