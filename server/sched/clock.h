// The clock as a parameter: mains and tests pass one in, so that neither the scheduler nor the session host reads a
// clock by itself.
#pragma once

#include <functional>

#include "base/time.h"

namespace foreland::server {

// Returns the present time of some monotonic clock; called from any thread.
using Clock = std::function<Time()>;

}  // namespace foreland::server
