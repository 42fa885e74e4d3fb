// The bytes that the server holds for one viewer: messages that have not arrived whole, that are not read yet or not
// sent yet, and what its session keeps (Session::keptBytes). Connection and session add to one account, so that a limit
// holds for both together. Private to server/net; any thread, and counts only: two who ask at once may both get the
// last of the room.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "base/result.h"
#include "server/net/host_limits.h"
#include "server/net/metrics/metrics.h"

namespace foreland::server {

class ViewerBytes {
 public:
  ViewerBytes(const HostLimits& limits, Metrics& metrics) : limits_(limits), metrics_(metrics) {}
  ViewerBytes(const ViewerBytes&) = delete;
  ViewerBytes& operator=(const ViewerBytes&) = delete;
  ~ViewerBytes() { metrics_.queue_bytes -= own_; }

  void add(int64_t bytes) {
    own_ += bytes;
    metrics_.queue_bytes += bytes;
  }
  int64_t own() const { return own_; }

  // Whether the viewer may make the server hold `more`; an Error tells the viewer why not. Where all viewers together
  // are at their limit, those may who hold no more than an even share of it: nobody's path refuses everybody else's.
  Status checkRoomFor(size_t more) const {
    const int64_t own = own_ + static_cast<int64_t>(more);
    if (own > static_cast<int64_t>(limits_.viewer_bytes))
      return Error{ErrorCode::kLimit, "you send or ask for more than this server holds for one viewer"};
    const auto most = static_cast<int64_t>(limits_.queue_bytes);
    const int64_t even_share = most / std::max<int64_t>(1, metrics_.sessions);
    if (metrics_.queue_bytes + static_cast<int64_t>(more) > most && own > even_share)
      return Error{ErrorCode::kLimit, "too much waits for this server already; try again later"};
    return {};
  }

 private:
  const HostLimits limits_;
  Metrics& metrics_;
  std::atomic<int64_t> own_{0};
};

}  // namespace foreland::server
