// Sockets as the tests need them: a raw TCP client and a WebSocket client by the letter of RFC 6455, sharing no code
// with the server. Every wait is bounded by kTimeout and ends a test rather than hanging it.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/bytes.h"

namespace foreland::test {

inline constexpr std::chrono::seconds kTimeout{20};

// Asks again and again, without sleeping, until it holds or the timeout ends. `holds` should do some waiting of its
// own.
template <class Condition>
bool eventually(Condition holds) {
  const auto end = std::chrono::steady_clock::now() + kTimeout;
  while (!holds())
    if (std::chrono::steady_clock::now() > end) return false;
  return true;
}

class Socket {
 public:
  // `receive_bytes`: size of the system's receive buffer, 0 for its default.
  explicit Socket(uint16_t port, int receive_bytes = 0) : fd_(::socket(AF_INET, SOCK_STREAM, 0)) {
    if (receive_bytes) ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &receive_bytes, sizeof(receive_bytes));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    is_connected_ = ::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  }
  ~Socket() {
    if (fd_ >= 0) ::close(fd_);
  }
  Socket(Socket&& other) noexcept : fd_(std::exchange(other.fd_, -1)), is_connected_(other.is_connected_) {}
  Socket& operator=(Socket&&) = delete;

  // A connection that was accepted.
  static Socket of(int fd) { return Socket(Accepted{fd}); }

  bool isConnected() const { return is_connected_; }
  // The peer gets what was sent before, then the end.
  void endSending() { ::shutdown(fd_, SHUT_WR); }
  // The peer's next read or write fails.
  void reset() {
    const linger at_once{1, 0};
    ::setsockopt(fd_, SOL_SOCKET, SO_LINGER, &at_once, sizeof(at_once));
    ::close(std::exchange(fd_, -1));
  }

  // False if the peer is gone.
  bool send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t sent = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent <= 0) return false;
      bytes.remove_prefix(static_cast<size_t>(sent));
    }
    return true;
  }

  bool isReadable(std::chrono::milliseconds wait) {
    pollfd p{fd_, POLLIN, 0};
    return ::poll(&p, 1, static_cast<int>(wait.count())) > 0;
  }

  // What comes next, at most `count` bytes; empty at the end of the stream, however it came.
  std::string receiveSome(size_t count) {
    if (!isReadable(kTimeout)) {
      ADD_FAILURE() << "the server says nothing and does not close";
      return {};
    }
    std::string bytes(count, '\0');
    const ssize_t got = ::recv(fd_, bytes.data(), count, 0);
    bytes.resize(got > 0 ? static_cast<size_t>(got) : 0);
    return bytes;
  }
  // Exactly `count` bytes, or nothing.
  std::optional<std::string> receive(size_t count) {
    std::string bytes;
    while (bytes.size() < count) {
      const std::string some = receiveSome(count - bytes.size());
      if (some.empty()) return std::nullopt;
      bytes += some;
    }
    return bytes;
  }
  std::string receiveToEnd() {
    std::string all;
    for (std::string some = receiveSome(65536); !some.empty(); some = receiveSome(65536)) all += some;
    return all;
  }

 private:
  struct Accepted {
    int fd;
  };
  explicit Socket(Accepted accepted) : fd_(accepted.fd), is_connected_(fd_ >= 0) {}

  int fd_;
  bool is_connected_ = false;
};

// The whole answer to `GET target` with "Connection: close"; `extra` are header lines that end in \r\n.
inline std::string httpGet(uint16_t port, const std::string& target, const std::string& extra = "",
                           const std::string& method = "GET") {
  Socket socket(port);
  socket.send(method + " " + target + " HTTP/1.1\r\nHost: test\r\nConnection: close\r\n" + extra + "\r\n");
  return socket.receiveToEnd();
}

// The value of one sample of /metrics, or -1.
inline double metric(uint16_t port, const std::string& name) {
  const std::string page = httpGet(port, "/metrics");
  const size_t at = page.find("\nforeland_" + name + " ");
  return at == std::string::npos ? -1 : std::stod(page.substr(at + name.size() + 11));
}

enum class Opcode : uint8_t { kContinuation = 0, kText = 1, kBinary = 2, kClose = 8, kPing = 9, kPong = 10 };

class WebSocketClient {
 public:
  struct Message {
    Opcode opcode;
    std::string payload;
    // Of a close frame; 0 if it carries none.
    int closeCode() const {
      return payload.size() < 2 ? 0 : static_cast<uint8_t>(payload[0]) << 8 | static_cast<uint8_t>(payload[1]);
    }
    Bytes bytes() const { return Bytes(payload.begin(), payload.end()); }
  };

  explicit WebSocketClient(uint16_t port, int receive_bytes = 0, const std::string& path = "/fly")
      : socket_(port, receive_bytes) {
    socket_.send("GET " + path +
                 " HTTP/1.1\r\nHost: test\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                 "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n");
    while (!reply_.ends_with("\r\n\r\n")) {
      const auto next = socket_.receive(1);
      if (!next) break;
      reply_ += *next;
    }
  }

  // The key's answer is the example of RFC 6455, section 1.3.
  bool isOpen() const {
    return reply_.starts_with("HTTP/1.1 101") && reply_.find("s3pPLMBiTxaQ9kYGzzhZRbK+xOo=") != std::string::npos;
  }
  const std::string& reply() const { return reply_; }
  Socket& socket() { return socket_; }

  bool send(const Bytes& message) { return sendFrame(Opcode::kBinary, std::string(message.begin(), message.end())); }
  bool sendFrame(Opcode opcode, const std::string& payload) {
    return socket_.send(frameHead(opcode, payload.size()) + payload);
  }
  // A final, masked frame's head; the mask is zero, so the payload follows as it is.
  static std::string frameHead(Opcode opcode, uint64_t size) {
    std::string head(1, static_cast<char>(0x80 | static_cast<uint8_t>(opcode)));
    const int size_bytes = size < 126 ? 0 : size < 65536 ? 2 : 8;
    head += static_cast<char>(0x80 | (size_bytes == 0 ? size : size_bytes == 2 ? 126 : 127));
    for (int i = size_bytes; i-- > 0;) head += static_cast<char>(size >> (8 * i));
    return head + std::string(4, '\0');
  }

  // The next whole message, fragments joined; nothing when the stream ends.
  std::optional<Message> receive() {
    Message message{Opcode::kContinuation, {}};
    while (true) {
      const auto head = socket_.receive(2);
      if (!head) return std::nullopt;
      const auto opcode = static_cast<Opcode>((*head)[0] & 15);
      const auto payload = receivePayload(static_cast<uint8_t>((*head)[1]));
      if (!payload) return std::nullopt;
      if (opcode >= Opcode::kClose) return Message{opcode, *payload};
      if (opcode != Opcode::kContinuation) message.opcode = opcode;
      message.payload += *payload;
      if ((*head)[0] & 0x80) return message;
    }
  }

  // Reads to the close frame and returns its code; 0 if the stream ends without.
  int receiveClose() {
    while (const auto message = receive())
      if (message->opcode == Opcode::kClose) return message->closeCode();
    return 0;
  }

 private:
  std::optional<std::string> receivePayload(uint8_t short_size) {
    EXPECT_LT(short_size, 128) << "a server does not mask";
    if (short_size < 126) return socket_.receive(short_size);
    const auto digits = socket_.receive(short_size == 126 ? 2 : 8);
    if (!digits) return std::nullopt;
    uint64_t size = 0;
    for (const char c : *digits) size = size << 8 | static_cast<uint8_t>(c);
    return socket_.receive(size);
  }

  Socket socket_;
  std::string reply_;
};

}  // namespace foreland::test
