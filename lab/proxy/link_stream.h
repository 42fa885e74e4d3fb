// One direction of a connection over a simulated link: the bytes that one end has sent, and when the other end gets
// them. The link is that of the virtual world (sim/link.h), so a piece of bytes that is handed over at a time
// arrives when a message of that size would there. No byte is lost, and they keep their order; the end of the stream
// arrives behind all of them. Bytes and times in, bytes out: whoever owns it reads the clock and the sockets.
#pragma once

#include <cstddef>
#include <optional>

#include "base/bytes.h"
#include "base/time.h"
#include "sim/link.h"

namespace foreland::lab {

class LinkStream {
 public:
  // On the way or not fetched by its receiver; one piece more at most, where a link has no rate that limits it sooner.
  static constexpr size_t kMaxBytes = 16u << 20;

  LinkStream(const sim::LinkOptions& options, uint64_t seed);

  // The largest piece to hand over at a time: what the link carries in 10 ms, for a piece arrives whole, and what
  // follows a short message must not delay it by more.
  size_t pieceBytes() const { return piece_bytes_; }
  // Whether the sender gets rid of more: all that it has sent has left it, the stream has not ended, and the receiver
  // keeps up.
  bool mayRead(Time now) const { return !has_ended_ && link_.drainedAt() <= now && bytes_ < kMaxBytes; }
  void take(Bytes piece, Time now);  // not empty; not after end()
  // The sender sends no more.
  void end(Time now);

  // All that has arrived and was not fetched before; empty if there is none.
  Bytes arrived(Time now);
  // Whether the end was fetched, and so everything before it.
  bool isOver() const { return is_over_; }
  // The first time after `now` at which something arrives, or more may be read; nothing if that depends on others.
  std::optional<Time> nextChange(Time now) const;

 private:
  sim::Link link_;
  size_t piece_bytes_;
  size_t bytes_ = 0;  // taken and not fetched
  bool has_ended_ = false, is_over_ = false;
};

}  // namespace foreland::lab
