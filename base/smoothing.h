// Exponential means: what was long ago counts less and less. Pure; any thread.
#pragma once

#include <cmath>

namespace foreland {

// The weight of a new value, `elapsed_s` after the last one, in a mean over about `memory_s`: however often values
// come, what one of them weighs falls to 1/e in that time.
inline double weightOfNew(double elapsed_s, double memory_s) { return 1 - std::exp(-elapsed_s / memory_s); }

}  // namespace foreland
