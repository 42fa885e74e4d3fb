// The clock of servers with real sockets: monotonic, from an arbitrary zero. Any thread.
#pragma once

#include <chrono>

#include "base/time.h"

namespace foreland::server {

inline Time steadyNow() {
  const auto since_zero = std::chrono::steady_clock::now().time_since_epoch();
  return {std::chrono::duration_cast<std::chrono::microseconds>(since_zero).count()};
}

}  // namespace foreland::server
