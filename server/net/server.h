// The server on its port: viewers by WebSocket, the page and its instruments by HTTP. One I/O thread owns the sockets,
// a pool computes; docs/THREADS.md says who owns what. The library behind it shows only in this folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "base/result.h"
#include "server/net/listen_address.h"
#include "server/net/session_host.h"
#include "server/sched/clock.h"
#include "server/session/session.h"

namespace foreland::server {

enum class Severity : uint8_t { kDebug, kInfo, kWarning };
// Called by the I/O thread, one line at a time.
using Log = std::function<void(Severity, const std::string&)>;

struct ServeOptions {
  ListenAddress listen;
  size_t threads = 2;
  SessionOptions session;
  HostLimits limits;
  std::filesystem::path web;  // empty: no page
  // Further files, by path: the images of the scene's models, as the page asks for them.
  std::map<std::string, std::string> files;
  size_t max_connections = 1024;          // further ones are closed at once
  size_t max_unread_messages = 64;        // a viewer that leaves more replies unread is refused
  size_t send_buffer_bytes = 128u << 10;  // of the system, per viewer; small, so that a slow link is noticed soon
  Duration http_timeout = Duration::seconds(10);  // for a request to arrive, and for its reply to leave
  Duration idle_timeout = Duration::seconds(30);  // a viewer that sends nothing, or reads nothing of what waits for it
  Duration stop_grace = Duration::milliseconds(500);  // for viewers to take leave
  Log log;                                            // may be empty
};

class Server {
 public:
  // Listens and serves until stop(). Errors: the address is bad or taken, the page's files cannot be read.
  static Result<std::unique_ptr<Server>> listen(std::shared_ptr<const World> world, ServeOptions options, Clock clock);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  uint16_t port() const;

  // Closes the port, takes leave of the viewers, joins the threads; within stop_grace and the steps in progress. May be
  // called again; by the owner's thread only.
  void stop();

 private:
  class Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace foreland::server
