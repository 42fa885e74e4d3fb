// What the server counts, and its text for Prometheus. Atomic counters: any thread adds, the I/O thread reads; a reader
// may see one counter a step ahead of another.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "server/sched/histogram.h"

namespace foreland::server {

struct Metrics {
  std::atomic<int64_t> connections{0};    // sockets open now
  std::atomic<int64_t> sessions{0};       // viewers now
  std::atomic<int64_t> section_nodes{0};  // held for them in all
  std::atomic<uint64_t> sessions_opened{0};
  std::atomic<uint64_t> refusals{0};  // viewers told to go
  std::atomic<uint64_t> http_requests{0};
  std::atomic<uint64_t> keyframes{0};
  std::atomic<uint64_t> skipped_keyframes{0};  // the last delta was still unsent
  std::atomic<uint64_t> late_keyframes{0};     // ready after their deadline
  std::atomic<uint64_t> bytes_down{0};         // payload written to viewers
  std::atomic<uint64_t> bytes_up{0};           // payload read from viewers
  std::atomic<uint64_t> messages_up{0};
  Histogram compute;  // time of one step of a session
};

// What the pool knows, beside the above.
struct PoolMetrics {
  size_t threads = 0;
  size_t queue_depth = 0;
  const Histogram* lateness = nullptr;
};

// The text exposition format, version 0.0.4.
std::string renderPrometheus(const Metrics& metrics, const PoolMetrics& pool);

}  // namespace foreland::server
