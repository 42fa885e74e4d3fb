// A TCP connection, in the clear or under TLS: one type for both, so that what is built on it is compiled once.
// Meets Asio's AsyncStream and what Beast's WebSocket asks of its next layer. Header only; shared by the server's and
// the player's sockets. One owner, one thread.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/beast/core/role.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <boost/beast/websocket/teardown.hpp>
#include <memory>
#include <utility>

namespace foreland::transport {

class Transport {
 public:
  using next_layer_type = boost::beast::tcp_stream;
  using executor_type = next_layer_type::executor_type;
  using Tls = boost::beast::ssl_stream<next_layer_type>;

  // In the clear.
  explicit Transport(next_layer_type stream) : plain_(std::make_unique<next_layer_type>(std::move(stream))) {}
  // Under TLS, once asyncHandshake has succeeded.
  Transport(next_layer_type stream, boost::asio::ssl::context& context)
      : tls_(std::make_unique<Tls>(std::move(stream), context)) {}

  executor_type get_executor() { return next_layer().get_executor(); }
  next_layer_type& next_layer() { return tls_ ? tls_->next_layer() : *plain_; }
  const next_layer_type& next_layer() const { return tls_ ? tls_->next_layer() : *plain_; }
  Tls* tls() { return tls_.get(); }  // null in the clear

  template <class Buffers, class Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    if (tls_)
      tls_->async_read_some(buffers, std::forward<Handler>(handler));
    else
      plain_->async_read_some(buffers, std::forward<Handler>(handler));
  }
  template <class Buffers, class Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    if (tls_)
      tls_->async_write_some(buffers, std::forward<Handler>(handler));
    else
      plain_->async_write_some(buffers, std::forward<Handler>(handler));
  }

 private:
  std::unique_ptr<next_layer_type> plain_;
  std::unique_ptr<Tls> tls_;
};

// How Beast ends the connection under a WebSocket.
inline void teardown(boost::beast::role_type role, Transport& transport, boost::beast::error_code& error) {
  using boost::beast::websocket::teardown;
  teardown(role, transport.next_layer().socket(), error);
}

// TLS' own farewell adds nothing to WebSocket's.
template <class Handler>
void async_teardown(boost::beast::role_type role, Transport& transport, Handler&& handler) {
  using boost::beast::websocket::async_teardown;
  async_teardown(role, transport.next_layer().socket(), std::forward<Handler>(handler));
}

}  // namespace foreland::transport
