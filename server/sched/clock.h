// The clock as a parameter: mains and tests pass it in, so nothing in the scheduler or the host reads one by itself.
#pragma once

#include <functional>

#include "base/time.h"

namespace foreland::server {

// The present on some monotonic clock; called from any thread.
using Clock = std::function<Time()>;

}  // namespace foreland::server
