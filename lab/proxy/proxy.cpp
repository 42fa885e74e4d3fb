#include "lab/proxy/proxy.h"

#include <pthread.h>

#include <atomic>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <set>
#include <thread>
#include <utility>

#include "lab/proxy/link_stream.h"
#include "server/net/listener.h"

namespace foreland::lab {

namespace net = boost::asio;
using net::ip::tcp;
using ErrorOf = boost::system::error_code;

namespace {

// Of the system, for each socket: what lies here is not on the simulated link, and its sender takes it for sent.
constexpr int kSystemBufferBytes = 64 << 10;

class Carriage;

// What all connections share. The proxy's thread, except the count.
struct Shared {
  net::io_context& io;
  const server::Clock& clock;
  Time zero;  // of the links' time
  std::atomic<size_t>& connections;
  std::set<std::shared_ptr<Carriage>> carriages{};

  Time now() const { return Time{} + (clock() - zero); }
};

// One connection, with its two directions. Lives in Shared::carriages until it is dropped.
class Carriage : public std::enable_shared_from_this<Carriage> {
 public:
  Carriage(Shared& shared, tcp::socket viewer, const sim::LinkPair& links, uint64_t up_seed, uint64_t down_seed)
      : shared_(shared),
        viewer_(std::move(viewer)),
        server_(shared.io),
        up_(shared.io, viewer_, server_, {links.up, up_seed}),
        down_(shared.io, server_, viewer_, {links.down, down_seed}) {
    ++shared_.connections;
  }
  ~Carriage() { --shared_.connections; }

  void start(const tcp::endpoint& to, const std::function<void(const std::string&)>& log) {
    ErrorOf ignored;
    server_.open(to.protocol(), ignored);
    prepare(viewer_), prepare(server_);
    server_.async_connect(to, [self = shared_from_this(), log](ErrorOf error) {
      if (self->is_dropped_) return;
      if (error && log) log("cannot connect to the server: " + error.message());
      if (error) return self->drop();
      self->turn(self->up_);
      self->turn(self->down_);
    });
  }

  void drop() {
    if (std::exchange(is_dropped_, true)) return;
    ErrorOf ignored;
    viewer_.close(ignored);
    server_.close(ignored);
    up_.timer.cancel();
    down_.timer.cancel();
    shared_.carriages.erase(shared_from_this());
  }

 private:
  struct Direction {
    Direction(net::io_context& io, tcp::socket& sender, tcp::socket& receiver, LinkStream link)
        : from(sender), to(receiver), stream(std::move(link)), timer(io) {}
    tcp::socket &from, &to;
    LinkStream stream;
    net::steady_timer timer;
    Bytes incoming, outgoing;  // of the read and the write in progress
    bool is_reading = false, is_writing = false, is_over = false;
  };

  static void prepare(tcp::socket& socket) {
    ErrorOf ignored;  // a socket that was closed meanwhile fails at the first read
    socket.set_option(tcp::no_delay(true), ignored);
    socket.set_option(net::socket_base::receive_buffer_size(kSystemBufferBytes), ignored);
    socket.set_option(net::socket_base::send_buffer_size(kSystemBufferBytes), ignored);
  }

  // Does what the link allows now, and comes back when it allows more.
  void turn(Direction& d) {
    if (is_dropped_) return;
    const Time now = shared_.now();
    if (!d.is_writing) write(d, now);
    if (is_dropped_) return;
    if (!d.is_reading && d.stream.mayRead(now)) read(d);
    const auto next = d.stream.nextChange(now);
    if (!next) return;
    d.timer.expires_after(std::chrono::microseconds((*next - now).us));
    d.timer.async_wait([self = shared_from_this(), &d](ErrorOf cancelled) {
      if (!cancelled) self->turn(d);
    });
  }

  void read(Direction& d) {
    d.is_reading = true;
    d.incoming.resize(d.stream.pieceBytes());
    d.from.async_read_some(net::buffer(d.incoming), [self = shared_from_this(), &d](ErrorOf error, size_t count) {
      d.is_reading = false;
      if (self->is_dropped_) return;
      if (error && error != net::error::eof) return self->drop();
      const Time now = self->shared_.now();
      if (count > 0) d.stream.take({d.incoming.begin(), d.incoming.begin() + static_cast<std::ptrdiff_t>(count)}, now);
      if (error) d.stream.end(now);
      self->turn(d);
    });
  }

  void write(Direction& d, Time now) {
    d.outgoing = d.stream.arrived(now);
    if (d.outgoing.empty()) return finish(d);
    d.is_writing = true;
    net::async_write(d.to, net::buffer(d.outgoing), [self = shared_from_this(), &d](ErrorOf error, size_t) {
      d.is_writing = false;
      if (self->is_dropped_) return;
      if (error) return self->drop();
      self->turn(d);
    });
  }

  void finish(Direction& d) {
    if (d.is_over || !d.stream.isOver()) return;
    d.is_over = true;
    ErrorOf ignored;
    d.to.shutdown(tcp::socket::shutdown_send, ignored);
    if (up_.is_over && down_.is_over) drop();
  }

  Shared& shared_;
  tcp::socket viewer_, server_;
  Direction up_, down_;
  bool is_dropped_ = false;
};

}  // namespace

class Proxy::Impl {
 public:
  Impl(ProxyOptions options, server::Clock clock)
      : options_(std::move(options)), clock_(std::move(clock)), shared_{io_, clock_, clock_(), connections_} {}
  ~Impl() { stop(); }

  Status open() {
    ErrorOf error;
    to_ = {net::ip::make_address(options_.to.host, error), options_.to.port};
    if (error)
      return Error{ErrorCode::kInvalidArgument, "'" + options_.to.host + "' is no address to connect to with --to"};
    for (const ProxyDoor& door : options_.doors) {
      doors_.push_back(std::make_unique<Door>(io_, door, eventsOf(doors_.size())));
      if (Status s = doors_.back()->listener.open(door.listen, "--listen"); !s.ok()) return s;
    }
    return {};
  }

  void start() {
    for (const auto& door : doors_) door->listener.accept();
    thread_ = std::jthread([this] {
      pthread_setname_np(pthread_self(), "proxy");
      io_.run();
    });
  }

  void stop() {
    if (!thread_.joinable()) return;
    net::post(io_, [this] {
      for (const auto& door : doors_) door->listener.close();
      while (!shared_.carriages.empty()) (*shared_.carriages.begin())->drop();
    });
    thread_.join();
  }

  uint16_t port(size_t door) const { return doors_[door]->listener.port(); }
  size_t connections() const { return connections_; }

 private:
  struct Door {
    Door(net::io_context& io, const ProxyDoor& door, server::Listener::Events events)
        : links(door.links), first_seed(door.seed), seeds(door.seed), listener(io, std::move(events)) {}
    sim::LinkPair links;
    uint64_t first_seed;
    Rng seeds;
    bool had_one = false;
    server::Listener listener;
  };

  server::Listener::Events eventsOf(size_t number) {
    return {.on_connection = [this, number](tcp::socket socket) { carry(*doors_[number], std::move(socket)); },
            .on_trouble =
                [this](const std::string& line) {
                  if (options_.log) options_.log(line);
                }};
  }

  void carry(Door& door, tcp::socket socket) {
    const bool is_first = !std::exchange(door.had_one, true);
    const uint64_t up = is_first ? door.first_seed : door.seeds.next();
    const uint64_t down = is_first ? door.first_seed + 1 : door.seeds.next();
    const auto carriage = std::make_shared<Carriage>(shared_, std::move(socket), door.links, up, down);
    shared_.carriages.insert(carriage);
    carriage->start(to_, options_.log);
  }

  const ProxyOptions options_;
  const server::Clock clock_;
  net::io_context io_{1};
  std::atomic<size_t> connections_{0};
  Shared shared_;
  tcp::endpoint to_;
  std::vector<std::unique_ptr<Door>> doors_;
  std::jthread thread_;
};

Proxy::Proxy(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Proxy::~Proxy() = default;

Result<std::unique_ptr<Proxy>> Proxy::open(ProxyOptions options, server::Clock clock) {
  auto impl = std::make_unique<Impl>(std::move(options), std::move(clock));
  if (Status s = impl->open(); !s.ok()) return s.error();
  impl->start();
  return std::unique_ptr<Proxy>(new Proxy(std::move(impl)));
}

uint16_t Proxy::port(size_t door) const { return impl_->port(door); }
size_t Proxy::connections() const { return impl_->connections(); }
void Proxy::stop() { impl_->stop(); }

}  // namespace foreland::lab
