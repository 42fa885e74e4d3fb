// How everything here is timed: the processor time of the calling thread, so that what else the machine does is left
// out, and medians with their spread, so that one hiccup is. Any thread.
#pragma once

#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace foreland::bench {

// Seconds that the calling thread has run; only differences mean anything.
inline double threadSeconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

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

}  // namespace foreland::bench
