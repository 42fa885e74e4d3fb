// What all connections of a server share. Private to server/net. The Server owns it, and it outlives every connection.
// What changes in it is used by the I/O thread alone, except the metrics and the host, which any thread may use.
#pragma once

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "server/net/access/gate.h"
#include "server/net/fleet_level.h"
#include "server/net/http/http_reply.h"
#include "server/net/metrics/metrics.h"
#include "server/net/server.h"
#include "server/net/session_host.h"

namespace foreland::server {

class ViewerConnection;

// What a connection may ask for.
enum class Admission : uint8_t {
  kWhole,    // a viewer, files, and what operators ask
  kReserve,  // only what operators ask, for the server is full
  kMetrics   // likewise, and it came to the port for that
};

struct ServerContext {
  const ServeOptions& options;
  const Clock& clock;
  const HttpSite& site;          // of the public port
  const HttpSite& metrics_site;  // of the port for operators
  boost::asio::io_context& io;
  SessionHost& host;
  Metrics& metrics;
  Gate& gate;
  std::map<std::string, size_t>& connections_from;   // open ones, by network
  std::shared_ptr<boost::asio::ssl::context> tls{};  // null: the public port is in the clear
  std::set<std::shared_ptr<ViewerConnection>> viewers{};
  bool is_draining = false;  // takes no further viewers
  FleetLevel fleet{};

  void log(Severity severity, const std::string& line) const {
    if (options.log) options.log(severity, line);
  }
};

// Of the other end, without its port; empty if the socket is closed already.
inline std::string addressOf(const boost::asio::ip::tcp::socket& socket) {
  boost::system::error_code error;
  const auto endpoint = socket.remote_endpoint(error);
  return error ? std::string() : addressText(endpoint.address());
}

// Counts one open socket, in the metrics and for its network (gate.h), as long as this object lives, whichever
// protocol the socket speaks. I/O thread.
class ConnectionCount {
 public:
  ConnectionCount(ServerContext& context, Admission admission, const boost::asio::ip::tcp::socket& socket)
      : open_(admission == Admission::kMetrics ? &context.metrics.metrics_connections : &context.metrics.connections),
        from_(&context.connections_from),
        address_(admission == Admission::kMetrics ? std::string() : addressOf(socket)) {
    ++*open_;
    ++(*from_)[networkOf(address_)];
  }
  ConnectionCount(ConnectionCount&& other) noexcept
      : open_(std::exchange(other.open_, nullptr)), from_(other.from_), address_(std::move(other.address_)) {}
  ConnectionCount& operator=(ConnectionCount&&) = delete;
  ~ConnectionCount() {
    if (!open_) return;
    --*open_;
    forget();
  }

  // A proxy has said whom the connection is for. Returns how many others there are of that network.
  size_t countFor(const std::string& address) {
    forget();
    address_ = address;
    return (*from_)[networkOf(address_)]++;
  }
  const std::string& address() const { return address_; }

 private:
  void forget() {
    const auto at = from_->find(networkOf(address_));
    if (at != from_->end() && --at->second == 0) from_->erase(at);
  }

  std::atomic<int64_t>* open_;
  std::map<std::string, size_t>* from_;
  std::string address_;
};

}  // namespace foreland::server
