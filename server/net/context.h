// What all connections of a server share. Private to server/net. The Server owns it, and it outlives every connection.
// What changes in it is used by the I/O thread alone, except the metrics and the host, which any thread may use.
#pragma once

#include <boost/asio/io_context.hpp>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "server/net/http_reply.h"
#include "server/net/metrics.h"
#include "server/net/server.h"
#include "server/net/session_host.h"

namespace foreland::server {

class ViewerConnection;

struct ServerContext {
  const ServeOptions& options;
  const Clock& clock;
  const HttpSite& site;
  boost::asio::io_context& io;
  SessionHost& host;
  Metrics& metrics;
  std::set<std::shared_ptr<ViewerConnection>> viewers{};

  void log(Severity severity, const std::string& line) const {
    if (options.log) options.log(severity, line);
  }
};

// Counts one open socket in the metrics for as long as this object lives, whichever protocol the socket speaks.
class ConnectionCount {
 public:
  explicit ConnectionCount(Metrics& metrics) : metrics_(&metrics) { ++metrics_->connections; }
  ConnectionCount(ConnectionCount&& other) noexcept : metrics_(std::exchange(other.metrics_, nullptr)) {}
  ConnectionCount& operator=(ConnectionCount&&) = delete;
  ~ConnectionCount() {
    if (metrics_) --metrics_->connections;
  }

 private:
  Metrics* metrics_;
};

}  // namespace foreland::server
