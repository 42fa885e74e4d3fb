// How much the server takes in from viewers and holds for them.
#pragma once

#include <cstddef>

namespace foreland::server {

struct HostLimits {
  size_t inbox_messages = 1024;  // not yet read, of one viewer; at 20 poses a second, most of a minute
  // What is held for one viewer: received and not read, made and not sent, or kept by its session (ViewerBytes). Two of
  // the largest messages.
  size_t viewer_bytes = 32u << 20;
  size_t queue_bytes = 256u << 20;  // likewise, for all viewers together
};

}  // namespace foreland::server
