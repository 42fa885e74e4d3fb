// The server on its port: it serves viewers by WebSocket, and the page, its files and the metrics by HTTP. One I/O
// thread owns the sockets and a pool computes; docs/THREADS.md says which thread owns what. Boost.Beast is used in this
// folder only.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "server/net/access/gate.h"
#include "server/net/access/listen_address.h"
#include "server/net/session_host.h"
#include "server/sched/clock.h"
#include "server/session/session.h"

namespace foreland::server {

enum class Severity : uint8_t { kDebug, kInfo, kWarning };
// Takes one line; called by the I/O thread.
using Log = std::function<void(Severity, const std::string&)>;

struct ServeOptions {
  ListenAddress listen;
  // A port of its own for /metrics, which the other then has not, and for /livez and /readyz.
  std::optional<ListenAddress> metrics_listen;
  // A port for HAProxy's agent-check: whoever connects is told in a line what part of its share this server should get.
  std::optional<ListenAddress> agent_listen;
  std::string version;  // of the program, for /metrics
  size_t threads = 2;
  SessionOptions session;
  HostLimits limits;
  std::filesystem::path web;  // directory of the page's files; empty for no page
  // More files by their paths in URLs: the images of the scene's models, overlays.
  std::map<std::string, std::string> files;
  GateOptions gate;
  // Of TLS on the public port; both empty for none.
  std::filesystem::path tls_certificate, tls_key;
  size_t max_connections = 1024;                  // one more is told to try again later (503)
  size_t max_connections_per_address = SIZE_MAX;  // likewise; behind a proxy all come from one
  size_t max_header_bytes = 8u << 10;             // of a request; a longer one is refused (431)
  size_t max_unread_messages = 64;                // a viewer that leaves more replies unread is refused
  size_t send_buffer_bytes = 128u << 10;  // the system's, for each viewer; small, so that a slow link is noticed early
  Duration http_timeout = Duration::seconds(10);     // for a request to arrive, and for its reply to leave
  Duration hello_timeout = Duration::seconds(10);    // for a viewer's first message to arrive
  Duration message_timeout = Duration::seconds(60);  // for a message that has begun to end
  Duration idle_timeout = Duration::seconds(30);  // a viewer that sends nothing, or reads nothing of what waits for it
  Duration stop_grace = Duration::milliseconds(500);  // for viewers to answer the close frame
  Log log;                                            // may be empty
};

// One of several scenes, at /NAME/.
struct ServedScene {
  std::string name;
  std::shared_ptr<const World> world;
};

class Server {
 public:
  // Listens and serves until stop(). An Error if the address cannot be listened on or the page's files cannot be read.
  static Result<std::unique_ptr<Server>> listen(std::shared_ptr<const World> world, ServeOptions options, Clock clock);
  // The same of several scenes, whose viewers share threads and limits: the page, with the files that `options` have
  // below /NAME/, and then those at the same path without it, is at /NAME/, and its viewers connect at /NAME/fly; `/`
  // shows the file /scenes.html. An Error also if a name will not do (scene_paths.h).
  static Result<std::unique_ptr<Server>> listen(std::vector<ServedScene> scenes, ServeOptions options, Clock clock);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  uint16_t port() const;
  uint16_t metricsPort() const;  // 0 if there is none
  uint16_t agentPort() const;    // likewise

  // Reads the certificate and its key again, for connections to come. An Error changes nothing. Owner's thread.
  Status reloadTls();

  // Takes no further viewers and migrates those that are here: each is asked, at its next keyframe, to connect again
  // and resume (close code 1012), and is so free to be sent to another server by a proxy. Plain HTTP is still
  // answered; /readyz says 503. Returns when all have gone, after `most` at the latest. By the owner's thread only,
  // before stop().
  void drain(Duration most);

  // Closes the port and the viewers' connections and joins the threads. Takes as long as stop_grace and the steps in
  // progress. May be called again; by the owner's thread only.
  void stop();

 private:
  class Impl;
  static Result<std::unique_ptr<Server>> listen(std::vector<std::shared_ptr<const World>> worlds,
                                                std::vector<std::string> names, ServeOptions options, Clock clock);
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace foreland::server
