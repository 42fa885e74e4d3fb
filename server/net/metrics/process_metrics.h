// What the system says of this process, by the names that Prometheus' own clients use. Any thread.
#pragma once

#include <cstdint>

namespace foreland::server {

struct ProcessMetrics {
  double cpu_seconds = 0;   // used, by all threads
  double start_time_s = 0;  // since 1970
  uint64_t resident_bytes = 0, virtual_bytes = 0;
  uint64_t open_fds = 0, max_fds = 0;
};

// What cannot be read is 0. Reads a few files of /proc.
ProcessMetrics processMetrics();

}  // namespace foreland::server
