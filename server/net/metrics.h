// What the server counts, and the text of it for Prometheus. The counters are atomic: any thread adds, the I/O thread
// reads, and may see one counter a step ahead of another.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "server/sched/histogram.h"

namespace foreland::server {

struct Metrics {
  std::atomic<int64_t> connections{0};                        // open sockets
  std::atomic<int64_t> sessions{0};                           // connected viewers
  std::atomic<int64_t> section_nodes{0};                      // of all viewers together
  std::atomic<int64_t> remembered_nodes{0}, memory_bytes{0};  // likewise, of what viewers know beside their sections
  std::atomic<uint64_t> sessions_opened{0};
  std::atomic<uint64_t> refusals{0};     // viewers that were disconnected for what they sent or did not read
  std::atomic<uint64_t> turned_away{0};  // connections, because there were too many
  std::atomic<uint64_t> handed_over{0};  // viewers asked to connect elsewhere, because the server stops
  std::atomic<uint64_t> http_requests{0};
  std::atomic<uint64_t> keyframes{0};
  std::atomic<uint64_t> skipped_keyframes{0};  // because the last delta was still unsent
  std::atomic<uint64_t> late_keyframes{0};     // ready after their deadline
  std::atomic<uint64_t> bytes_down{0};         // payload written to viewers
  std::atomic<uint64_t> bytes_up{0};           // payload read from viewers
  std::atomic<uint64_t> messages_up{0};
  std::atomic<uint64_t> replies{0};     // to requests for tours and ground heights
  std::atomic<uint64_t> resumed{0};     // sessions that started from a section that the viewer held
  std::atomic<uint64_t> jumps{0};       // of viewers' cameras
  std::atomic<uint64_t> failures{0};    // exceptions, each of which ended one viewer or request
  std::atomic<int64_t> queue_bytes{0};  // of messages received and not yet read, and made and not yet sent
  std::atomic<int64_t> flying{0};       // viewers that have been sent a keyframe
  Histogram messages;                   // the time that reading one lease's messages took
  Histogram compute;                    // the time of one step of a session
};

// The state of the pool.
struct PoolMetrics {
  size_t threads = 0;
  size_t queue_depth = 0;
  const Histogram* lateness = nullptr;
};

// The text exposition format, version 0.0.4.
std::string renderPrometheus(const Metrics& metrics, const PoolMetrics& pool);

}  // namespace foreland::server
