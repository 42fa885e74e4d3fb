#include "transport/web_socket.h"

#include <boost/beast/websocket/stream.hpp>
#include <utility>

namespace foreland::transport {

namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;

struct WebSocket::Stream : websocket::stream<Transport, false> {  // false: no permessage-deflate
  using websocket::stream<Transport, false>::stream;
};

WebSocket::WebSocket(Transport transport) : stream_(std::make_unique<Stream>(std::move(transport))) {
  stream_->auto_fragment(false);
  stream_->binary(true);
}
WebSocket::WebSocket(WebSocket&&) noexcept = default;
WebSocket& WebSocket::operator=(WebSocket&&) noexcept = default;
WebSocket::~WebSocket() = default;

Transport& WebSocket::transport() { return stream_->next_layer(); }

void WebSocket::setLimits(const Limits& limits) {
  auto timeout = limits.pings ? websocket::stream_base::timeout::suggested(beast::role_type::client)
                              : websocket::stream_base::timeout{.handshake_timeout = {},
                                                                .idle_timeout = websocket::stream_base::none(),
                                                                .keep_alive_pings = false};
  timeout.handshake_timeout = limits.handshake_timeout;
  stream_->set_option(timeout);
  stream_->read_message_max(limits.max_message_bytes);
}

void WebSocket::accept(const UpgradeRequest& request, const std::string& server, Done done) {
  stream_->set_option(websocket::stream_base::decorator(
      [server](websocket::response_type& response) { response.set(http::field::server, server); }));
  stream_->async_accept(request, std::move(done));
}

void WebSocket::shakeHands(const std::string& host, const std::string& target, const std::string& authorization,
                           Answer& answer, Done done) {
  if (!authorization.empty())
    stream_->set_option(websocket::stream_base::decorator(
        [authorization](websocket::request_type& request) { request.set(http::field::authorization, authorization); }));
  answer = {};
  const auto response = std::make_shared<websocket::response_type>();
  response->result(0u);
  stream_->async_handshake(*response, host, target, [response, &answer, done = std::move(done)](Error error) {
    answer.status = response->result_int();
    if (error && (*response)[http::field::content_type].starts_with("text/plain")) answer.text = response->body();
    done(error);
  });
}

void WebSocket::readSome(beast::flat_buffer& buffer, Moved moved) {
  stream_->async_read_some(buffer, 0, std::move(moved));
}
void WebSocket::read(beast::flat_buffer& buffer, Moved moved) { stream_->async_read(buffer, std::move(moved)); }
bool WebSocket::isMessageDone() const { return stream_->is_message_done(); }
bool WebSocket::gotText() const { return stream_->got_text(); }

// A write of a last piece is a write of a whole message to Beast.
void WebSocket::write(boost::asio::const_buffer message, Moved moved) {
  writeSome(Piece::kLast, message, std::move(moved));
}
void WebSocket::writeSome(Piece piece, boost::asio::const_buffer bytes, Moved moved) {
  stream_->async_write_some(piece == Piece::kLast, bytes, std::move(moved));
}

void WebSocket::close(const CloseReason& reason, Done done) { stream_->async_close(reason, std::move(done)); }
const WebSocket::CloseReason& WebSocket::reason() const { return stream_->reason(); }

}  // namespace foreland::transport
