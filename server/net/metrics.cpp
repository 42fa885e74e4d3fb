#include "server/net/metrics.h"

#include <fmt/format.h>

#include <iterator>

namespace foreland::server {
namespace {

class Page {
 public:
  void gauge(const char* name, const char* help, int64_t value) { single(name, help, "gauge", value); }
  void counter(const char* name, const char* help, uint64_t value) {
    single(name, help, "counter", static_cast<int64_t>(value));
  }

  void histogram(const char* name, const char* help, const Histogram& samples) {
    head(name, help, "histogram");
    uint64_t total = 0;
    for (size_t i = 0; i < Histogram::kBounds.size(); ++i) {
      total += samples.count(i);
      write("foreland_{}_bucket{{le=\"{}\"}} {}\n", name, static_cast<double>(Histogram::kBounds[i].us) / 1e6, total);
    }
    total += samples.count(Histogram::kBounds.size());
    write("foreland_{0}_bucket{{le=\"+Inf\"}} {1}\nforeland_{0}_sum {2}\nforeland_{0}_count {1}\n", name, total,
          samples.sum().toSeconds());
  }

  std::string take() { return std::move(text_); }

 private:
  template <class... Args>
  void write(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
  }
  void head(const char* name, const char* help, const char* kind) {
    write("# HELP foreland_{0} {1}\n# TYPE foreland_{0} {2}\n", name, help, kind);
  }
  void single(const char* name, const char* help, const char* kind, int64_t value) {
    head(name, help, kind);
    write("foreland_{} {}\n", name, value);
  }

  std::string text_;
};

}  // namespace

std::string renderPrometheus(const Metrics& m, const PoolMetrics& pool) {
  Page page;
  page.gauge("connections", "Open sockets.", m.connections);
  page.gauge("sessions", "Viewers connected.", m.sessions);
  page.gauge("section_nodes", "Nodes in the sections of all viewers.", m.section_nodes);
  page.gauge("remembered_nodes", "Nodes that viewers remember beside their sections.", m.remembered_nodes);
  page.gauge("memory_bytes", "Bytes that the server needs to know which.", m.memory_bytes);
  page.counter("sessions_opened_total", "Viewers that ever connected.", m.sessions_opened);
  page.counter("refusals_total", "Viewers refused for what they sent or did not read.", m.refusals);
  page.counter("turned_away_total", "Connections turned away because there were too many.", m.turned_away);
  page.counter("handed_over_total", "Viewers asked to connect elsewhere, because the server stops.", m.handed_over);
  page.counter("http_requests_total", "Plain HTTP requests.", m.http_requests);
  page.counter("keyframes_total", "Keyframes computed.", m.keyframes);
  page.counter("skipped_keyframes_total", "Keyframes left out because the last one was unsent.", m.skipped_keyframes);
  page.counter("late_keyframes_total", "Keyframes computed after their deadline.", m.late_keyframes);
  page.counter("bytes_down_total", "Payload bytes written to viewers.", m.bytes_down);
  page.counter("bytes_up_total", "Payload bytes read from viewers.", m.bytes_up);
  page.counter("messages_up_total", "Messages read from viewers.", m.messages_up);
  page.counter("replies_total", "Replies to requests for tours and ground heights.", m.replies);
  page.counter("resumed_total", "Sessions that started from a section that the viewer held.", m.resumed);
  page.counter("jumps_total", "Jumps of viewers' cameras.", m.jumps);
  page.counter("failures_total", "Exceptions, each of which ended one viewer or request.", m.failures);
  page.gauge("queue_bytes", "Bytes of messages received and not read, or made and not sent.", m.queue_bytes);
  page.gauge("flying", "Viewers that have been sent a keyframe.", m.flying);
  page.gauge("worker_threads", "Threads of the pool.", static_cast<int64_t>(pool.threads));
  page.gauge("queue_depth", "Jobs released and not yet started.", static_cast<int64_t>(pool.queue_depth));
  page.histogram("compute_seconds", "Time of one step of a session.", m.compute);
  page.histogram("message_seconds", "Time of reading the messages that a session found waiting.", m.messages);
  if (pool.lateness) page.histogram("lateness_seconds", "By how much jobs ended after their deadline.", *pool.lateness);
  return page.take();
}

}  // namespace foreland::server
