#include "server/net/metrics/metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <string>
#include <utility>

namespace foreland::server {
namespace {

class Page {
 public:
  template <class Value>
  void gauge(const std::string& name, const char* help, Value value) {
    head(name, help, "gauge");
    write("{} {}\n", name, value);
  }
  template <class Value>
  void counter(const std::string& name, const char* help, Value value) {
    head(name, help, "counter");
    write("{} {}\n", name, value);
  }
  // One line for each value of a label.
  template <class Names, class Values>
  void counters(const std::string& name, const char* help, const char* label, const Names& names,
                const Values& values) {
    head(name, help, "counter");
    for (size_t i = 0; i < names.size(); ++i) write("{}{{{}=\"{}\"}} {}\n", name, label, names[i], uint64_t{values[i]});
  }
  template <class Labelled>
  void gauges(const std::string& name, const char* help, const char* label, const Labelled& values) {
    if (values.empty()) return;
    head(name, help, "gauge");
    for (const auto& [key, value] : values) write("{}{{{}=\"{}\"}} {}\n", name, label, key, value);
  }
  void info(const std::string& name, const char* help, const char* label, const std::string& value) {
    head(name, help, "gauge");
    write("{}{{{}=\"{}\"}} 1\n", name, label, value);
  }

  void histogram(const std::string& name, const char* help, const Histogram& samples) {
    head(name, help, "histogram");
    uint64_t total = 0;
    for (size_t i = 0; i < Histogram::kBounds.size(); ++i) {
      total += samples.count(i);
      write("{}_bucket{{le=\"{}\"}} {}\n", name, static_cast<double>(Histogram::kBounds[i].us) / 1e6, total);
    }
    total += samples.count(Histogram::kBounds.size());
    write("{0}_bucket{{le=\"+Inf\"}} {1}\n{0}_sum {2}\n{0}_count {1}\n", name, total, samples.sum().toSeconds());
  }

  std::string take() { return std::move(text_); }

 private:
  template <class... Args>
  void write(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
  }
  void head(const std::string& name, const char* help, const char* kind) {
    write("# HELP {0} {1}\n# TYPE {0} {2}\n", name, help, kind);
  }

  std::string text_;
};

constexpr std::array<const char*, kRefusals> kRefusalNames = {"full",    "address", "stopping", "origin", "token",
                                                              "message", "queues",  "unread",   "scene",  "silent"};

void renderViewers(const Metrics& m, Page& page) {
  page.gauge("foreland_connections", "Open sockets.", m.connections.load());
  page.gauge("foreland_sessions", "Viewers connected.", m.sessions.load());
  page.gauge("foreland_flying", "Viewers that have been sent a keyframe.", m.flying.load());
  page.counter("foreland_sessions_opened_total", "Viewers that ever connected.", m.sessions_opened.load());
  page.counters("foreland_refusals_total", "Connections and viewers refused, by reason.", "reason", kRefusalNames,
                m.refusals);
  page.counter("foreland_handed_over_total",
               "Viewers asked to connect elsewhere, because the server stops or is busier than others.",
               m.migrated.load());
  page.counter("foreland_resumed_total", "Sessions that started from a section that the viewer held.",
               m.resumed.load());
  page.counter("foreland_failures_total", "Exceptions, each of which ended one viewer or request.", m.failures.load());
  page.counters("foreland_http_replies_total", "Replies to HTTP requests, by status.", "code", kHttpStatuses,
                m.http_replies);
}

void renderKeyframes(const Metrics& m, Page& page) {
  page.counter("foreland_keyframes_total", "Keyframes computed.", m.keyframes.load());
  page.counter("foreland_skipped_keyframes_total", "Keyframes left out because the last one was unsent.",
               m.skipped_keyframes.load());
  page.counter("foreland_late_keyframes_total", "Keyframes computed after their deadline.", m.late_keyframes.load());
  page.counter("foreland_replies_total", "Replies to requests for tours and ground heights.", m.replies.load());
  page.counter("foreland_jumps_total", "Jumps of viewers' cameras.", m.jumps.load());
  const int64_t flying = m.flying;
  page.gauge("foreland_tolerance_px", "Mean tolerance in force, of flying viewers.",
             flying > 0 ? static_cast<double>(m.tolerances_mpx) / (1000.0 * static_cast<double>(flying)) : 0);
  page.gauge("foreland_coarse", "Flying viewers whose tolerance is above what they asked for.", m.coarse.load());
  page.histogram("foreland_compute_seconds", "Time of one step of a session.", m.compute);
  page.histogram("foreland_message_seconds", "Time of reading the messages that a session found waiting.", m.messages);
}

void renderOcclusion(const Metrics& m, Page& page) {
  page.gauge("foreland_occlusion_viewers", "Viewers who are sent nothing of what is hidden.", m.occluding.load());
  page.gauge("foreland_occlusion_left_out_nodes", "Nodes left out of the sections of these, as last compared.",
             m.left_out_nodes.load());
  page.counter("foreland_occlusion_seconds_total", "Processor time for finding out what is hidden, by its usual cost.",
               1e-6 * static_cast<double>(m.occlusion_us.load()));
  page.counters("foreland_occlusion_shed_total", "Viewers who were sent what is hidden again.", "for",
                std::array{"load", "use"}, m.occlusion_shed);
}

void renderBytes(const Metrics& m, Page& page) {
  page.gauge("foreland_section_nodes", "Nodes in the sections of all viewers.", m.section_nodes.load());
  page.gauge("foreland_remembered_nodes", "Nodes that viewers remember beside their sections.",
             m.remembered_nodes.load());
  page.gauge("foreland_memory_bytes", "Bytes that the server needs to know which, and what ridges hide.",
             m.memory_bytes.load());
  page.gauge("foreland_queue_bytes", "Bytes received and not read, kept for viewers, or made and not sent.",
             m.queue_bytes.load());
  page.counter("foreland_bytes_down_total", "Payload bytes written to viewers.", m.bytes_down.load());
  page.counter("foreland_bytes_up_total", "Payload bytes read from viewers.", m.bytes_up.load());
  page.counter("foreland_messages_up_total", "Messages read from viewers.", m.messages_up.load());
}

void renderCodedPages(const CodedPageCounts& pages, Page& page) {
  page.gauge("foreland_page_cache_bytes", "Ground that is held inflated.", pages.held_bytes);
  page.counter("foreland_page_cache_inflated_total", "Groups of pages inflated.", pages.inflated);
  page.counter("foreland_page_cache_woken_total", "Groups touched that were near to being evicted.", pages.woken);
  page.counter("foreland_page_cache_evicted_total", "Groups evicted.", pages.evicted);
  page.counter("foreland_page_cache_damaged_total", "Groups that could not be inflated.", pages.damaged);
}

void renderStore(const Metrics& m, const StoreCounts& store, Page& page) {
  page.gauge("foreland_store_lacking", "Flying viewers whose tolerance is raised for what is not there yet.",
             m.lacking.load());
  page.gauge("foreland_store_wished_chunks", "Chunks that viewers would like to be fetched.", store.wished);
  page.gauge("foreland_store_cache_bytes", "Bytes of scenes at a distance that are there.", store.there_bytes);
  page.gauge("foreland_store_held_bytes", "Of these, bytes that somebody's section needs.", store.held_bytes);
  page.gauge("foreland_store_capacity_bytes", "The most that may be there.", store.capacity_bytes);
  page.counter("foreland_store_uses_total", "Times that a viewer began to need a chunk that was there.", store.uses);
  page.counter("foreland_store_fetched_chunks_total", "Chunks fetched from stores.", store.fetched);
  page.counter("foreland_store_fetched_bytes_total", "Their bytes.", store.fetched_bytes);
  page.counter("foreland_store_evicted_chunks_total", "Chunks that made room for others.", store.evicted);
  page.counters("foreland_store_failures_total", "Fetches that failed, by reason.", "reason",
                std::array{"read", "checksum", "room"}, store.failures);
}

void renderState(const ServerState& state, Page& page) {
  page.info("foreland_build_info", "The program.", "version", state.version);
  page.gauge("foreland_uptime_seconds", "Time since the server started.", state.uptime_s);
  page.gauge("foreland_worker_threads", "Threads of the pool.", state.threads);
  page.gauge("foreland_pool_load", "Share of these threads' time that was used in the last half second.", state.load);
  page.gauge("foreland_io_load", "Share of the time of the thread for connections that was used in the last second.",
             state.io_load);
  page.gauge("foreland_processor_load",
             "Share of the time of the processors that this process may use that was used in the last second.",
             state.processor_load);
  if (state.fleet_load)
    page.gauge("foreland_fleet_load",
               "The largest of these, of all servers in the mean, as their balancer says it: up to 0.85, or 1.",
               *state.fleet_load);
  page.gauge("foreland_queue_depth", "Jobs released and not yet started.", state.queue_depth);
  page.gauges("foreland_scene_sessions", "Viewers connected, by scene.", "scene", state.viewers_by_scene);
  if (state.lateness)
    page.histogram("foreland_lateness_seconds", "By how much jobs ended after their deadline.", *state.lateness);
  if (state.coded_pages) renderCodedPages(*state.coded_pages, page);
  const ProcessMetrics& process = state.process;
  page.counter("process_cpu_seconds_total", "Processor time used.", process.cpu_seconds);
  page.gauge("process_start_time_seconds", "When the process started, since 1970.", process.start_time_s);
  page.gauge("process_resident_memory_bytes", "Memory in use.", process.resident_bytes);
  page.gauge("process_virtual_memory_bytes", "Addresses in use.", process.virtual_bytes);
  page.gauge("process_open_fds", "Open descriptors.", process.open_fds);
  page.gauge("process_max_fds", "The most descriptors that may be open.", process.max_fds);
}

}  // namespace

void Metrics::countHttpReply(unsigned status) {
  const auto at = std::find(kHttpStatuses.begin(), kHttpStatuses.end() - 1, status);
  ++http_replies[static_cast<size_t>(at - kHttpStatuses.begin())];
}

std::string renderPrometheus(const Metrics& metrics, const ServerState& state) {
  Page page;
  renderViewers(metrics, page);
  renderKeyframes(metrics, page);
  renderOcclusion(metrics, page);
  renderBytes(metrics, page);
  if (state.store) renderStore(metrics, *state.store, page);
  renderState(state, page);
  return page.take();
}

}  // namespace foreland::server
