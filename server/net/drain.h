// How a server hands its viewers over before it stops: each is asked to connect again, which a proxy answers with
// another server. They are asked one after another, so that the others need not resume all of them in one instant.
// Private to server/net; I/O thread.
#pragma once

#include <cstddef>

#include "base/time.h"
#include "server/net/context.h"

namespace foreland::server {

class Drain {
 public:
  // At most `most` is taken; the viewers are asked within half of that, and faster if they are few.
  Drain(ServerContext& context, Time now, Duration most);

  // Asks those whose turn it is. To be called every few milliseconds.
  void step(Time now);

  // Whether all have gone, or the time is over.
  bool isOver(Time now) const;

 private:
  size_t turnsBy(Time now) const;

  ServerContext& context_;
  const Time begin_, end_;
  const size_t viewers_;
  const Duration spread_;
  size_t asked_ = 0;
};

}  // namespace foreland::server
