// When a piece of work of a viewer may start, and by when it should be done: what a session says of what it has to do,
// and what the queue of jobs goes by. A plain value.
#pragma once

#include <optional>

#include "base/time.h"

namespace foreland::server {

struct Due {
  Time release;
  Time deadline;
  bool is_costly = false;  // may take up to a second, so that not all workers should do such work at a time (Pool)
  Duration work{};         // how long it is expected to take; 0: nothing is planned for it
  // From when it may be started, if others would be late otherwise; nothing: not before its release.
  std::optional<Time> earliest{};
  Time key{};  // of orders that are told it from outside (toldKey); others do without
};

}  // namespace foreland::server
