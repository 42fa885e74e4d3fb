// A WebSocket connection to a server, driven from one thread: sending queues, and run() moves bytes both ways until a
// given moment. The only place of the client that knows sockets and Boost; nothing of Boost shows here, and no
// exception leaves. One owner, one thread.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "base/bytes.h"
#include "base/result.h"

namespace foreland::client {

struct WebSocketUrl {
  std::string host;
  std::string port = "80";
  std::string target = "/";
};

// ws://HOST[:PORT][/PATH]; an IPv6 address stands in brackets. Anything else is an Error that says so.
Result<WebSocketUrl> parseWebSocketUrl(const std::string& url);

class WebSocketClient {
 public:
  using Clock = std::chrono::steady_clock;

  // Resolves, connects and shakes hands; at most `timeout` each.
  static Result<WebSocketClient> connect(const std::string& url, std::chrono::milliseconds timeout);
  ~WebSocketClient();
  WebSocketClient(WebSocketClient&&) noexcept;
  WebSocketClient& operator=(WebSocketClient&&) noexcept;

  // Queues one binary message.
  void send(Bytes message);
  // Sends, receives and waits until `until`; hands over each message as it comes. An Error from `on_message` stops and
  // is returned; so is the loss of the connection, after all messages that came before it.
  Status run(Clock::time_point until, const std::function<Status(ByteSpan)>& on_message);
  // Says goodbye, waiting a second at most.
  void close();

 private:
  struct Impl;
  explicit WebSocketClient(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace foreland::client
