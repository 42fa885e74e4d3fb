// What the server counts, and the text of it for Prometheus. The counters are atomic: any thread adds, the I/O thread
// reads, and may see one counter a step ahead of another.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/net/metrics/process_metrics.h"
#include "server/sched/histogram.h"

namespace foreland::server {

// Why a connection or a viewer was refused.
enum class RefusedFor : uint8_t {
  kFull,     // there were too many connections
  kAddress,  // likewise, from its address
  kStopping,
  kOrigin,   // the page that it comes from may not
  kToken,    // it has no token, or not one that lets it in
  kMessage,  // what it sent
  kQueues,   // more waited for this server than it takes
  kUnread,   // it read nothing, or too slowly
  kScene,    // its address is that of no scene
  kSilent,   // it sent nothing for too long, or did not end a message
};
inline constexpr size_t kRefusals = 10;

// That replies to plain requests may have. Others are counted as the last one.
inline constexpr std::array kHttpStatuses = {101u, 200u, 206u, 304u, 308u, 400u, 401u,
                                             403u, 404u, 405u, 416u, 426u, 503u, 500u};

struct Metrics {
  void count(RefusedFor reason) { ++refusals[static_cast<size_t>(reason)]; }
  void countHttpReply(unsigned status);

  std::atomic<int64_t> connections{0};                        // open sockets of the public port
  std::atomic<int64_t> metrics_connections{0};                // of the port for operators
  std::atomic<int64_t> sessions{0};                           // connected viewers
  std::atomic<int64_t> section_nodes{0};                      // of all viewers together
  std::atomic<int64_t> remembered_nodes{0}, memory_bytes{0};  // likewise, of what viewers know beside their sections
  std::atomic<uint64_t> sessions_opened{0};
  std::array<std::atomic<uint64_t>, kRefusals> refusals{};
  std::atomic<uint64_t> migrated{
      0};  // viewers asked to connect elsewhere, because the server stops or is busier than others
  std::array<std::atomic<uint64_t>, kHttpStatuses.size()> http_replies{};
  std::atomic<uint64_t> keyframes{0};
  std::atomic<uint64_t> skipped_keyframes{0};  // because the last delta was still unsent
  std::atomic<uint64_t> late_keyframes{0};     // ready after their deadline
  std::atomic<uint64_t> bytes_down{0};         // payload written to viewers
  std::atomic<uint64_t> bytes_up{0};           // payload read from viewers
  std::atomic<uint64_t> messages_up{0};
  std::atomic<uint64_t> replies{0};                       // to requests for tours and ground heights
  std::atomic<uint64_t> resumed{0};                       // sessions that started from a section that the viewer held
  std::atomic<uint64_t> jumps{0};                         // of viewers' cameras
  std::atomic<uint64_t> failures{0};                      // exceptions, each of which ended one viewer or request
  std::atomic<int64_t> queue_bytes{0};                    // that are held for viewers (viewer_bytes.h)
  std::atomic<int64_t> flying{0};                         // viewers that have been sent a keyframe
  std::atomic<int64_t> tolerances_mpx{0};                 // of all flying viewers, in force, thousandths of a pixel
  std::atomic<int64_t> coarse{0};                         // flying viewers whose tolerance is above what they asked for
  std::atomic<int64_t> lacking{0};                        // of these, for want of pages of a scene at a distance
  std::atomic<int64_t> occluding{0};                      // viewers whose last keyframe left out what is hidden
  std::atomic<int64_t> left_out_nodes{0};                 // of these, as last compared
  std::atomic<uint64_t> occlusion_us{0};                  // that finding it out took, by its usual cost
  std::array<std::atomic<uint64_t>, 2> occlusion_shed{};  // viewers from whom it was withdrawn: load, use
  Histogram messages;                                     // the time that reading one lease's messages took
  Histogram compute;                                      // the time of one step of a session
};

// The state of the server beside its counters.
// What is known of coded pages, in groups (terrain/store/coded).
struct CodedPageCounts {
  uint64_t held_bytes = 0, inflated = 0, woken = 0, evicted = 0, damaged = 0;
};

// What is known of scenes at a distance (terrain/store/distant).
struct StoreCounts {
  uint64_t there_bytes = 0, held_bytes = 0, capacity_bytes = 0, wished = 0;
  uint64_t uses = 0, fetched = 0, fetched_bytes = 0, evicted = 0;
  std::array<uint64_t, 3> failures{};  // reads that failed, chunks that were not sound, no room
};

struct ServerState {
  std::string version;
  double uptime_s = 0;
  ProcessMetrics process;

  size_t threads = 0;
  double load = 0, io_load = 0, processor_load = 0;
  std::optional<double> fleet_load{};  // the mean of all servers, where a balancer says it
  size_t queue_depth = 0;
  const Histogram* lateness = nullptr;
  std::optional<CodedPageCounts> coded_pages{};                     // of scenes whose pages are coded
  std::optional<StoreCounts> store{};                               // of scenes at a distance
  std::vector<std::pair<std::string, int64_t>> viewers_by_scene{};  // of a server with several scenes
};

// The text exposition format, version 0.0.4.
std::string renderPrometheus(const Metrics& metrics, const ServerState& state);

}  // namespace foreland::server
