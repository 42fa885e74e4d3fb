// Hands a server's viewers over before it stops (server/session/migration.h).
// Private to server/net; I/O thread.
#pragma once

#include <cstddef>

#include "base/time.h"
#include "server/net/context.h"
#include "server/session/migration.h"

namespace foreland::server {

class Drain {
 public:
  // At most `most` is taken.
  Drain(ServerContext& context, Time now, Duration most);

  // Asks those whose turn it is. To be called every few milliseconds.
  void step(Time now);

  // Whether all have gone, or the time is over.
  bool isOver(Time now) const;

 private:
  ServerContext& context_;
  const Time end_;
  const MigrationTurns turns_;
  size_t asked_ = 0;
};

}  // namespace foreland::server
