// A WebSocket connection to a server, driven from one thread: sending queues, and run() moves bytes both ways until a
// given moment, or until another thread wakes it. The only file of the client that knows sockets and Boost; nothing of
// Boost shows here, and no exception leaves. One owner, one thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "base/bytes.h"
#include "base/result.h"

namespace foreland::client {

enum class Security : uint8_t { kNone, kTls };

struct WebSocketUrl {
  Security security = Security::kNone;
  std::string host;
  std::string port = "80";
  std::string target = "/";
};

// ws://HOST[:PORT][/PATH], or wss:// for TLS; http and https mean the same. An IPv6 address stands in brackets.
// Anything else is an Error that names the form.
Result<WebSocketUrl> parseWebSocketUrl(const std::string& url);

// How a connection ended.
enum class LostBy : uint8_t {
  kFailure,
  kMigrate  // the server asked to connect again at once and to resume (close code 1012)
};

// A target with the viewer's area in its query, in place of one that it has.
std::string withArea(const std::string& target, uint32_t area);

class WebSocketClient {
 public:
  using Clock = std::chrono::steady_clock;

  struct Options {
    std::string token;               // a bearer token for the server; empty for none
    std::optional<uint32_t> area{};  // of the scene, that the viewer is in (client/area.h): a part of the address
    std::string ca_file;             // certificates of authorities to trust, in PEM format; empty for the system's
    // How the one who is told of an Error gives these.
    std::string token_advice = "give a valid token with --token", ca_advice = "--ca names the authority";
    std::stop_token stop;  // ends connecting, but not the system's search for a host's name
  };

  // Resolves the name, connects and shakes hands; each may take `timeout` at most, but the first.
  static Result<WebSocketClient> connect(const std::string& url, std::chrono::milliseconds timeout,
                                         const Options& options);
  static Result<WebSocketClient> connect(const std::string& url, std::chrono::milliseconds timeout);
  ~WebSocketClient();
  WebSocketClient(WebSocketClient&&) noexcept;
  WebSocketClient& operator=(WebSocketClient&&) noexcept;

  // Queues one binary message.
  void send(Bytes message);
  // Sends and receives until `until`, and calls `on_message` with each message as it arrives. An Error from
  // `on_message` ends the run and is returned; so is the loss of the connection, after all messages that arrived before
  // it.
  Status run(Clock::time_point until, const std::function<Status(ByteSpan)>& on_message);
  // Ends a run that is under way, or else the next one, at once. Any thread.
  void wake();
  // Bytes that were queued and have not been written.
  size_t unsentBytes() const;
  // Of the last run's Error.
  LostBy lostBy() const;
  // Closes the connection with a close frame; waits for the server's so long at most.
  void close(std::chrono::milliseconds longest = std::chrono::seconds(1));

 private:
  struct Impl;
  explicit WebSocketClient(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace foreland::client
