// What carries a message adds to it: WebSocket's frame header (RFC 6455, 5.2). TCP's and IP's are not counted: they
// belong to packets, not to messages. Pure.
#pragma once

#include <cstddef>

namespace foreland::sim {

enum class Direction { kDown, kUp };  // clients mask what they send, with four bytes

constexpr size_t frameHeaderBytes(size_t message_bytes, Direction direction) {
  const size_t length_bytes = message_bytes < 126 ? 0 : message_bytes < 65'536 ? 2 : 8;
  return 2 + length_bytes + (direction == Direction::kUp ? 4 : 0);
}

}  // namespace foreland::sim
