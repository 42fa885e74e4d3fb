#include "server/net/server.h"

#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <future>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "server/net/context.h"
#include "server/net/drain.h"
#include "server/net/http_connection.h"
#include "server/net/viewer_connection.h"
#include "server/sched/pool.h"

namespace foreland::server {
namespace net = boost::asio;
using net::ip::tcp;
using ErrorOf = boost::system::error_code;
namespace {

std::chrono::microseconds chrono(Duration d) { return std::chrono::microseconds(d.us); }

Error cannotListen(const ListenAddress& address, const ErrorOf& why) {
  const std::string name = toString(address);
  if (why == net::error::address_in_use)
    return {ErrorCode::kIo,
            fmt::format("cannot listen on {}: another program uses the port {}; stop it, or give another "
                        "port with --listen {} (port 0 picks a free one)",
                        name, address.port, toString({address.host, 0}))};
  if (why == net::error::access_denied)
    return {ErrorCode::kIo,
            fmt::format("cannot listen on {}: the port {} is reserved to the system; give one above 1023 "
                        "with --listen",
                        name, address.port)};
  return {ErrorCode::kIo,
          fmt::format("cannot listen on {}: {}; give an address of this machine with --listen", name, why.message())};
}

}  // namespace

// Members use those declared above them, so they are destroyed in the right order.
class Server::Impl {
 public:
  Impl(std::shared_ptr<const World> world, ServeOptions options, StaticFiles files, Clock clock)
      : options_(std::move(options)),
        clock_(std::move(clock)),
        pool_(options_.threads, clock_, [this](const char* what) { failed(what); }),
        host_(std::move(world), options_.session, options_.limits, pool_, clock_, metrics_),
        site_{.files = std::move(files),
              .metrics = [this] { return metricsText(); },
              .unready = [this] { return unready(); }},
        context_{options_, clock_, site_, io_, host_, metrics_, connections_from_} {}

  ~Impl() { stop(); }

  Status listen() {
    ErrorOf error;
    const auto address = net::ip::make_address(options_.listen.host, error);
    if (error) return cannotListen(options_.listen, error);
    const tcp::endpoint endpoint(address, options_.listen.port);
    acceptor_.open(endpoint.protocol(), error);
    if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor_.bind(endpoint, error);
    if (!error) acceptor_.listen(net::socket_base::max_listen_connections, error);
    if (!error) port_ = acceptor_.local_endpoint(error).port();
    if (error) return cannotListen(options_.listen, error);
    return {};
  }

  void start() {
    accept();
    watch();
    io_thread_ = std::jthread([this] { runIo(); });
  }

  uint16_t port() const { return port_; }

  void drain(Duration most) {
    net::post(io_, [this, most] { beginDrain(most); });
    drained_.get_future().wait();
  }

  // The order of docs/THREADS.md: port, viewers, I/O thread, workers.
  void stop() {
    if (io_thread_.joinable()) {
      net::post(io_, [this] { takeLeave(); });
      io_thread_.join();
    }
    pool_.stop();
  }

 private:
  void runIo() {
    pthread_setname_np(pthread_self(), "io");
    while (!io_.stopped()) {
      try {
        io_.run();
      } catch (const std::exception& e) {  // one connection failed (out of memory, say); the others continue
        failed(e.what());
      }
    }
  }

  void accept() {
    acceptor_.async_accept([this](ErrorOf error, tcp::socket socket) {
      if (!acceptor_.is_open()) return;
      if (error) return retryAccept(error);
      guarded([&] { admit(std::move(socket)); });
      accept();
    });
  }

  // Loops go on whatever one turn of theirs throws.
  template <class Turn>
  void guarded(const Turn& turn) {
    try {
      turn();
    } catch (const std::exception& e) { failed(e.what()); }
  }

  // Any thread.
  void failed(const char* what) noexcept {
    ++metrics_.failures;
    try {
      net::post(io_,
                [this, line = std::string("a connection failed: ") + what] { context_.log(Severity::kWarning, line); });
    } catch (...) {}  // no memory even for the log
  }

  // Usually there are no descriptors left: wait for some connections to close.
  void retryAccept(const ErrorOf& error) {
    context_.log(Severity::kWarning, "cannot accept a connection: " + error.message());
    accept_timer_.expires_after(std::chrono::milliseconds(100));
    accept_timer_.async_wait([this](ErrorOf cancelled) {
      if (!cancelled && acceptor_.is_open()) accept();
    });
  }

  void admit(tcp::socket socket) {
    if (metrics_.connections >= static_cast<int64_t>(options_.max_connections))
      return turnAway(std::move(socket), fmt::format("there are {} connections already", options_.max_connections));
    const auto from = context_.connections_from.find(addressOf(socket));
    if (from != context_.connections_from.end() && from->second >= options_.max_connections_per_address)
      return turnAway(std::move(socket),
                      fmt::format("there are {} connections from its address already", from->second));
    ErrorOf ignored;  // a socket that was closed meanwhile fails at the first read
    socket.set_option(tcp::no_delay(true), ignored);
    socket.set_option(net::socket_base::send_buffer_size(static_cast<int>(options_.send_buffer_bytes)), ignored);
    serveHttp(std::move(socket), context_);
  }

  // Says why, and does not wait for whether it is read.
  void turnAway(tcp::socket socket, const std::string& why) {
    ++metrics_.turned_away;
    context_.log(Severity::kDebug, "turned a connection away: " + why);
    static constexpr std::string_view kReply =
        "HTTP/1.1 503 Service Unavailable\r\nServer: foreland\r\nRetry-After: 5\r\nConnection: close\r\n"
        "Content-Type: text/plain; charset=utf-8\r\nContent-Length: 40\r\n\r\nThe server is full. Try again in a "
        "while\n";
    ErrorOf ignored;
    socket.non_blocking(true, ignored);
    socket.write_some(net::buffer(kReply), ignored);
    socket.shutdown(tcp::socket::shutdown_send, ignored);
  }

  // Why no further viewer should come; empty if one may.
  std::string unready() const {
    if (is_stopping_ || context_.is_draining) return "The server stops.";
    if (metrics_.connections >= static_cast<int64_t>(options_.max_connections)) return "The server is full.";
    return host_.isOverloaded() ? "The server is overloaded." : "";
  }

  void watch() {
    watch_timer_.expires_after(chrono(std::min(Duration{options_.idle_timeout.us / 4}, Duration::seconds(1))));
    watch_timer_.async_wait([this](ErrorOf cancelled) {
      if (cancelled) return;
      const Time now = clock_();
      guarded([&] {
        for (const auto& viewer : everyViewer()) viewer->check(now);
      });
      watch();
    });
  }

  void beginDrain(Duration most) {
    context_.is_draining = true;
    context_.log(Severity::kInfo, fmt::format("hands {} viewers over", context_.viewers.size()));
    drain_.emplace(context_, clock_(), most);
    continueDrain();
  }

  void continueDrain() {
    guarded([&] { drain_->step(clock_()); });
    if (drain_->isOver(clock_())) return drained_.set_value();
    drain_timer_.expires_after(std::chrono::milliseconds(10));
    drain_timer_.async_wait([this](ErrorOf) { continueDrain(); });
  }

  void takeLeave() {
    ErrorOf ignored;
    is_stopping_ = true;
    acceptor_.close(ignored);
    watch_timer_.cancel();
    for (const auto& viewer : everyViewer())
      viewer->leave(boost::beast::websocket::close_code::going_away, "the server stops");
    stop_by_ = std::chrono::steady_clock::now() + chrono(options_.stop_grace);
    awaitLeave();
  }

  // Polls, for that happens once only, and no connection has to report that it was the last.
  void awaitLeave() {
    if (context_.viewers.empty() || std::chrono::steady_clock::now() >= stop_by_) return io_.stop();
    watch_timer_.expires_after(std::chrono::milliseconds(5));
    watch_timer_.async_wait([this](ErrorOf) { awaitLeave(); });
  }

  // Iterates over a copy, because a call may remove its viewer from the set.
  std::vector<std::shared_ptr<ViewerConnection>> everyViewer() const {
    return {context_.viewers.begin(), context_.viewers.end()};
  }

  std::string metricsText() const {
    return renderPrometheus(
        metrics_, {.threads = pool_.threadCount(), .queue_depth = pool_.queueDepth(), .lateness = &pool_.lateness()});
  }

  const ServeOptions options_;
  const Clock clock_;
  Metrics metrics_;
  std::map<std::string, size_t> connections_from_;
  Pool pool_;
  SessionHost host_;
  HttpSite site_;
  net::io_context io_{1};  // its handlers hold the connections, whose destructors use the members above
  ServerContext context_;
  tcp::acceptor acceptor_{io_};
  net::steady_timer accept_timer_{io_};
  net::steady_timer watch_timer_{io_};
  net::steady_timer drain_timer_{io_};
  std::optional<Drain> drain_;  // I/O thread
  std::promise<void> drained_;
  std::chrono::steady_clock::time_point stop_by_;
  uint16_t port_ = 0;
  bool is_stopping_ = false;  // I/O thread
  std::jthread io_thread_;
};

Result<std::unique_ptr<Server>> Server::listen(std::shared_ptr<const World> world, ServeOptions options, Clock clock) {
  StaticFiles files;
  if (!options.web.empty()) {
    auto loaded = StaticFiles::load(options.web);
    if (!loaded) return loaded.error();
    files = std::move(*loaded);
  }
  for (auto& [path, body] : options.files) files.add(path, std::move(body));
  options.files.clear();
  auto impl = std::make_unique<Impl>(std::move(world), std::move(options), std::move(files), std::move(clock));
  if (Status status = impl->listen(); !status.ok()) return status.error();
  impl->start();
  return std::unique_ptr<Server>(new Server(std::move(impl)));
}

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Server::~Server() = default;
uint16_t Server::port() const { return impl_->port(); }
void Server::drain(Duration most) { impl_->drain(most); }
void Server::stop() { impl_->stop(); }

}  // namespace foreland::server
