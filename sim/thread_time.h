// The processor time of the calling thread, which leaves out what else the machine does. Any thread.
#pragma once

#include <time.h>

namespace foreland::sim {

// Seconds that the calling thread has run; only differences mean anything.
inline double threadSeconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace foreland::sim
