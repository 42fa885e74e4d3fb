// A WebSocket of whole binary messages over a Transport, for the server's viewers and for the player. Beast's templates
// are instantiated in web_socket.cpp alone, once for both. Handlers are called on the thread that runs the transport's
// executor; a handler of a WebSocket that is destroyed before is never called, or called with an error. One owner, one
// thread. Messages are not compressed.
#pragma once

#include <boost/asio/buffer.hpp>
#include <boost/beast/core/error.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/websocket/error.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "transport/transport.h"

namespace foreland::transport {

using UpgradeRequest = boost::beast::http::request<boost::beast::http::string_body>;

class WebSocket {
 public:
  using Error = boost::beast::error_code;
  using Done = std::function<void(Error)>;
  using Moved = std::function<void(Error, size_t bytes)>;
  using CloseReason = boost::beast::websocket::close_reason;

  explicit WebSocket(Transport transport);
  WebSocket(WebSocket&&) noexcept;
  WebSocket& operator=(WebSocket&&) noexcept;
  ~WebSocket();

  Transport& transport();

  // Before the handshake: how long it and the answer to a close frame may take, and the size of the largest message
  // that is taken.
  struct Limits {
    std::chrono::microseconds handshake_timeout{};
    size_t max_message_bytes = 0;
    // An idle peer is pinged, and given up if it does not answer; for clients.
    bool pings = false;
  };
  void setLimits(const Limits& limits);

  // Answers an upgrade request, which must live until `done`; `server` is what the answer's Server field says.
  void accept(const UpgradeRequest& request, const std::string& server, Done done);
  // What a server answers to a handshake.
  struct Answer {
    unsigned status = 0;  // of HTTP; 0 if there was no answer
    std::string text;     // what it says, of a refusal in plain text
  };
  // Asks for an upgrade; with an Authorization field unless `authorization` is empty. `answer` must live until `done`.
  void shakeHands(const std::string& host, const std::string& target, const std::string& authorization, Answer& answer,
                  Done done);

  // Appends some bytes of the next message; isMessageDone() says whether it is whole.
  void readSome(boost::beast::flat_buffer& buffer, Moved moved);
  // Appends the next message.
  void read(boost::beast::flat_buffer& buffer, Moved moved);
  bool isMessageDone() const;
  bool gotText() const;

  // The bytes must live until `moved`. One write at a time.
  enum class Piece : uint8_t { kMore, kLast };  // of a message
  void write(boost::asio::const_buffer message, Moved moved);
  void writeSome(Piece piece, boost::asio::const_buffer bytes, Moved moved);

  // Sends a close frame and waits for the peer's.
  void close(const CloseReason& reason, Done done);
  // What the peer's close frame said.
  const CloseReason& reason() const;

 private:
  struct Stream;
  std::unique_ptr<Stream> stream_;
};

}  // namespace foreland::transport
