#include "lab/wire/peers/entropy.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace foreland::lab {

double orderZeroEntropyBits(std::span<const int32_t> values) {
  std::vector<int32_t> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  const double total = static_cast<double>(sorted.size());
  double bits = 0;
  for (auto at = sorted.begin(); at != sorted.end();) {
    const auto next = std::upper_bound(at, sorted.end(), *at);
    const double share = static_cast<double>(next - at) / total;
    bits -= share * std::log2(share);
    at = next;
  }
  return bits;
}

}  // namespace foreland::lab
