// Quantiles of measured values: a median with its median absolute deviation leaves out what one hiccup does. Pure; any
// thread. O(n).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace foreland {

// 0 if there are no values. `q` from 0 (the least value) to 1 (the largest).
inline double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

inline double median(std::vector<double> values) { return quantile(std::move(values), 0.5); }

// Median absolute deviation from the median.
inline double medianDeviation(const std::vector<double>& values) {
  const double centre = median(values);
  std::vector<double> deviations;
  for (double v : values) deviations.push_back(std::fabs(v - centre));
  return median(std::move(deviations));
}

}  // namespace foreland
