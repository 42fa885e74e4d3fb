// How everything here is timed: the processor time of the calling thread, so that what else the machine does is left
// out, and medians with their spread, so that one hiccup is. Any thread.
#pragma once

#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace foreland::bench {

// Seconds that the calling thread has run; only differences mean anything.
inline double threadSeconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// 0 if there are no values.
inline double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Median absolute deviation from the median.
inline double medianDeviation(const std::vector<double>& values) {
  const double centre = median(values);
  std::vector<double> deviations;
  for (double v : values) deviations.push_back(std::fabs(v - centre));
  return median(std::move(deviations));
}

}  // namespace foreland::bench
