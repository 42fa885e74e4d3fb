#include "transport/transport.h"

#include <openssl/ssl.h>

#include <boost/beast/ssl/ssl_stream.hpp>
#include <boost/beast/websocket/teardown.hpp>

namespace foreland::transport {

namespace asio = boost::asio;
namespace beast = boost::beast;

struct Transport::Streams {
  using Tls = beast::ssl_stream<next_layer_type>;
  std::unique_ptr<next_layer_type> plain;
  std::unique_ptr<Tls> tls;
};

Transport::Transport(next_layer_type stream)
    : streams_(new Streams{std::make_unique<next_layer_type>(std::move(stream)), nullptr}) {}

Transport::Transport(next_layer_type stream, asio::ssl::context& context)
    : streams_(new Streams{nullptr, std::make_unique<Streams::Tls>(std::move(stream), context)}) {}

Transport::Transport(Transport&&) noexcept = default;
Transport& Transport::operator=(Transport&&) noexcept = default;
Transport::~Transport() = default;

bool Transport::isTls() const { return streams_->tls != nullptr; }

Transport::next_layer_type& Transport::next_layer() {
  return streams_->tls ? streams_->tls->next_layer() : *streams_->plain;
}
const Transport::next_layer_type& Transport::next_layer() const {
  return streams_->tls ? streams_->tls->next_layer() : *streams_->plain;
}

void Transport::handshakeAsServer(Done done) {
  streams_->tls->async_handshake(asio::ssl::stream_base::server, std::move(done));
}

void Transport::handshakeAsClient(const std::string& host, Done done) {
  SSL_set_tlsext_host_name(streams_->tls->native_handle(), host.c_str());
  streams_->tls->async_handshake(asio::ssl::stream_base::client, std::move(done));
}

void Transport::shutDownTls(Done done) { streams_->tls->async_shutdown(std::move(done)); }

void Transport::readSome(const FewBuffers<asio::mutable_buffer>& buffers, Completion completion) {
  if (streams_->tls)
    streams_->tls->async_read_some(buffers, std::move(completion));
  else
    streams_->plain->async_read_some(buffers, std::move(completion));
}

void Transport::writeSome(const FewBuffers<asio::const_buffer>& buffers, Completion completion) {
  if (streams_->tls)
    streams_->tls->async_write_some(buffers, std::move(completion));
  else
    streams_->plain->async_write_some(buffers, std::move(completion));
}

void teardown(beast::role_type role, Transport& transport, beast::error_code& error) {
  beast::websocket::teardown(role, transport.next_layer().socket(), error);
}

void tearDown(beast::role_type role, Transport& transport, Completion completion) {
  beast::websocket::async_teardown(role, transport.next_layer().socket(),
                                   [done = std::move(completion)](beast::error_code error) mutable { done(error, 0); });
}

}  // namespace foreland::transport
