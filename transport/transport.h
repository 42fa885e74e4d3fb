// A TCP connection, in the clear or under TLS: one type for both, which meets Asio's AsyncStream and what Beast's
// WebSocket asks of its next layer. What Beast instantiates for each handler ends here, at a handler of one type
// (Completion), so that the layers below are compiled once, in transport.cpp. Shared by the server's and the player's
// sockets. One owner, one thread.
#pragma once

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/beast/core/error.hpp>
#include <boost/beast/core/role.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

namespace foreland::transport {

// What is called once when bytes have come or gone. It owns a handler of any type, which need not be copyable; one that
// is never called is destroyed. Costs one allocation.
class Completion {
 public:
  template <class Handler>
  explicit Completion(Handler handler) : handler_(std::make_unique<Holder<Handler>>(std::move(handler))) {}

  void operator()(boost::beast::error_code error, size_t bytes) {
    const std::unique_ptr<Erased> handler = std::move(handler_);
    handler->complete(error, bytes);
  }

 private:
  struct Erased {
    virtual ~Erased() = default;
    virtual void complete(boost::beast::error_code error, size_t bytes) = 0;
  };
  template <class Handler>
  struct Holder final : Erased {
    explicit Holder(Handler h) : handler(std::move(h)) {}
    void complete(boost::beast::error_code error, size_t bytes) override {
      Handler last = std::move(handler);  // it may end the connection that this belongs to
      last(error, bytes);
    }
    Handler handler;
  };
  std::unique_ptr<Erased> handler_;
};

// The first buffers of a sequence: a stream may read or write less than it is given.
template <class Buffer>
struct FewBuffers {
  static constexpr size_t kMax = 16;
  std::array<Buffer, kMax> buffers{};
  size_t count = 0;

  template <class Buffers>
  explicit FewBuffers(const Buffers& all) {
    for (auto it = boost::asio::buffer_sequence_begin(all); it != boost::asio::buffer_sequence_end(all); ++it) {
      if (count == kMax) return;
      buffers[count++] = *it;
    }
  }
  // Asio's buffer sequences.
  using value_type = Buffer;
  using const_iterator = const Buffer*;
  const_iterator begin() const { return buffers.data(); }
  const_iterator end() const { return buffers.data() + count; }
};

class Transport {
 public:
  using next_layer_type = boost::beast::tcp_stream;
  using executor_type = next_layer_type::executor_type;

  // In the clear.
  explicit Transport(next_layer_type stream);
  // Under TLS, once asyncHandshake has succeeded.
  Transport(next_layer_type stream, boost::asio::ssl::context& context);
  Transport(Transport&&) noexcept;
  Transport& operator=(Transport&&) noexcept;
  ~Transport();

  bool isTls() const;
  executor_type get_executor() { return next_layer().get_executor(); }
  next_layer_type& next_layer();
  const next_layer_type& next_layer() const;

  // Under TLS only. `host` is the name that a client asks for (SNI); empty for a server.
  using Done = std::function<void(boost::beast::error_code)>;
  void handshakeAsServer(Done done);
  void handshakeAsClient(const std::string& host, Done done);
  void shutDownTls(Done done);

  template <class Buffers, class Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    readSome(FewBuffers<boost::asio::mutable_buffer>(buffers),
             Completion(std::decay_t<Handler>(std::forward<Handler>(handler))));
  }
  template <class Buffers, class Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    writeSome(FewBuffers<boost::asio::const_buffer>(buffers),
              Completion(std::decay_t<Handler>(std::forward<Handler>(handler))));
  }

 private:
  void readSome(const FewBuffers<boost::asio::mutable_buffer>& buffers, Completion completion);
  void writeSome(const FewBuffers<boost::asio::const_buffer>& buffers, Completion completion);

  struct Streams;
  std::unique_ptr<Streams> streams_;
};

// How Beast ends the connection under a WebSocket. TLS' own farewell adds nothing to WebSocket's.
void teardown(boost::beast::role_type role, Transport& transport, boost::beast::error_code& error);
void tearDown(boost::beast::role_type role, Transport& transport, Completion completion);
template <class Handler>
void async_teardown(boost::beast::role_type role, Transport& transport, Handler&& handler) {
  tearDown(role, transport,
           Completion([h = std::decay_t<Handler>(std::forward<Handler>(handler))](boost::beast::error_code error,
                                                                                  size_t) mutable { h(error); }));
}

}  // namespace foreland::transport
