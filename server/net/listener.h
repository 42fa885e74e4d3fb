// A port that takes connections. For server/net, and for the proxy of experiments (lab/proxy/proxy.h). I/O thread,
// except open().
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <functional>
#include <string>

#include "base/result.h"
#include "server/net/access/listen_address.h"

namespace foreland::server {

class Listener {
 public:
  struct Events {
    std::function<void(boost::asio::ip::tcp::socket)> on_connection;  // must not throw
    std::function<void(const std::string&)> on_trouble;               // a line for the log
  };
  Listener(boost::asio::io_context& io, Events events) : acceptor_(io), retry_timer_(io), events_(std::move(events)) {}

  // An Error if the address cannot be listened on; it names `flag`, by which the user can choose another.
  Status open(const ListenAddress& address, const std::string& flag);
  uint16_t port() const { return port_; }

  // Calls on_connection with one socket after another until close(). Does nothing if that goes on already; it ends if
  // there is no memory to wait for the next one, which leaves a handler as an exception.
  void accept();
  void close();

 private:
  void retry(const boost::system::error_code& error);

  boost::asio::ip::tcp::acceptor acceptor_;
  boost::asio::steady_timer retry_timer_;
  Events events_;
  uint16_t port_ = 0;
  bool is_waiting_ = false;  // for a connection, or to try again
};

}  // namespace foreland::server
