#include "server/net/listener.h"

#include <fmt/format.h>

#include <boost/asio/error.hpp>
#include <chrono>
#include <utility>

namespace foreland::server {
namespace net = boost::asio;
using net::ip::tcp;
using ErrorOf = boost::system::error_code;
namespace {

Error cannotListen(const ListenAddress& address, const std::string& flag, const ErrorOf& why) {
  const std::string name = toString(address);
  if (why == net::error::address_in_use)
    return {ErrorCode::kIo,
            fmt::format("cannot listen on {}: another program uses the port {}; stop it, or give another "
                        "port with {} {} (port 0 picks a free one)",
                        name, address.port, flag, toString({address.host, 0}))};
  if (why == net::error::access_denied)
    return {ErrorCode::kIo,
            fmt::format("cannot listen on {}: the port {} is reserved to the system; give one above 1023 with {}", name,
                        address.port, flag)};
  return {ErrorCode::kIo,
          fmt::format("cannot listen on {}: {}; give an address of this machine with {}", name, why.message(), flag)};
}

}  // namespace

Status Listener::open(const ListenAddress& listen, const std::string& flag) {
  ErrorOf error;
  const auto address = net::ip::make_address(listen.host, error);
  if (error) return cannotListen(listen, flag, error);
  const tcp::endpoint endpoint(address, listen.port);
  acceptor_.open(endpoint.protocol(), error);
  if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor_.bind(endpoint, error);
  if (!error) acceptor_.listen(net::socket_base::max_listen_connections, error);
  if (!error) port_ = acceptor_.local_endpoint(error).port();
  if (error) return cannotListen(listen, flag, error);
  return {};
}

void Listener::accept() {
  if (is_waiting_ || !acceptor_.is_open()) return;
  acceptor_.async_accept([this](ErrorOf error, tcp::socket socket) {
    is_waiting_ = false;
    if (!acceptor_.is_open()) return;
    if (error) return retry(error);
    events_.on_connection(std::move(socket));
    accept();
  });
  is_waiting_ = true;
}

// Usually there are no descriptors left: wait for some connections to close.
void Listener::retry(const ErrorOf& error) {
  events_.on_trouble("cannot accept a connection: " + error.message());
  retry_timer_.expires_after(std::chrono::milliseconds(100));
  retry_timer_.async_wait([this](ErrorOf cancelled) {
    is_waiting_ = false;
    if (!cancelled) accept();
  });
  is_waiting_ = true;
}

void Listener::close() {
  ErrorOf ignored;
  acceptor_.close(ignored);
}

}  // namespace foreland::server
