#include "server/net/server.h"

#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <functional>
#include <future>
#include <optional>
#include <span>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "base/guarded.h"
#include "server/net/access/tls.h"
#include "server/net/context.h"
#include "server/net/drain.h"
#include "server/net/http/scene_paths.h"
#include "server/net/http_connection.h"
#include "server/net/listener.h"
#include "server/net/memory_return.h"
#include "server/net/metrics/load.h"
#include "server/net/metrics/processor_use.h"
#include "server/net/rebalance.h"
#include "server/net/repeater.h"
#include "server/net/viewer_connection.h"
#include "server/sched/pool.h"

namespace foreland::server {
namespace net = boost::asio;
using net::ip::tcp;
using ErrorOf = boost::system::error_code;
namespace {

std::chrono::microseconds chrono(Duration d) { return std::chrono::microseconds(d.us); }

// Connections beyond max_connections, in which operators alone are answered, and those of their own port.
constexpr int64_t kReserve = 16, kMaxMetricsConnections = 64;

}  // namespace

// Members use those declared above them, so they are destroyed in the right order.
class Server::Impl {
 public:
  Impl(std::vector<std::shared_ptr<const World>> worlds, std::vector<std::string> names, ServeOptions options,
       StaticFiles files, Clock clock)
      : options_(std::move(options)),
        clock_(std::move(clock)),
        worlds_(std::move(worlds)),
        pool_(options_.threads, clock_, [this](const char* what) { failed(what); }),
        host_(worlds_, options_.session, options_.limits, pool_, clock_, metrics_),
        site_{.files = std::move(files),
              .metrics = options_.metrics_listen ? std::function<std::string()>() : [this] { return metricsText(); },
              .unready = [this] { return unready(1); },
              .scenes = std::move(names)},
        metrics_site_{
            .files = {}, .metrics = [this] { return metricsText(); }, .unready = [this] { return unready(0); }},
        gate_(options_.gate),
        context_{options_, clock_, site_, metrics_site_, io_, host_, metrics_, gate_, connections_from_} {}

  ~Impl() { stop(); }

  Status listen() {
    if (Status status = check(options_.gate); !status.ok()) return status;
    if (Status status = loadTls(); !status.ok()) return status;
    if (Status status = listener_.open(options_.listen, "--listen"); !status.ok()) return status;
    if (options_.metrics_listen)
      if (Status status = metrics_listener_.open(*options_.metrics_listen, "--metrics-listen"); !status.ok())
        return status;
    return options_.agent_listen ? agent_listener_.open(*options_.agent_listen, "--agent-listen") : Status();
  }

  // A null one if there is to be none.
  Status loadTls() {
    if (options_.tls_certificate.empty() && options_.tls_key.empty()) return {};
    if (options_.tls_certificate.empty() || options_.tls_key.empty())
      return Error{ErrorCode::kInvalidArgument, "TLS needs both --tls-cert and --tls-key"};
    auto tls = server::loadTls(options_.tls_certificate, options_.tls_key);
    if (!tls) return tls.error();
    net::post(io_, [this, tls = std::move(*tls)] { context_.tls = tls; });
    return {};
  }

  void start() {
    resumeListeners();
    watch();
    io_thread_ = std::jthread([this] { runIo(); });
  }

  uint16_t port() const { return listener_.port(); }
  uint16_t metricsPort() const { return metrics_listener_.port(); }
  uint16_t agentPort() const { return agent_listener_.port(); }

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
  // Whatever leaves a handler (one connection failed, out of memory, say), the others continue. It may have been the
  // handler of a loop that could not wait for its next turn.
  void runIo() {
    pthread_setname_np(pthread_self(), "io");
    while (!io_.stopped())
      guarded([this] {
        resumeLoops();
        io_.run();
      });
  }

  void resumeListeners() {
    listener_.accept();
    if (options_.metrics_listen) metrics_listener_.accept();
    if (options_.agent_listen) agent_listener_.accept();
  }

  void resumeLoops() {
    resumeListeners();
    for (Repeater* loop : {&watch_, &drain_loop_, &leave_loop_}) loop->resume();
  }

  template <class Work>
  void guarded(const Work& work) {
    foreland::guarded(work, [this](const char* what) { failed(what); });
  }

  Listener::Events eventsOf(std::function<void(tcp::socket)> take) {
    return {.on_connection = [this, take](tcp::socket socket) { guarded([&] { take(std::move(socket)); }); },
            .on_trouble = [this](const std::string& line) { context_.log(Severity::kWarning, line); }};
  }

  // Any thread.
  void failed(const char* what) noexcept {
    ++metrics_.failures;
    try {
      net::post(io_, [this, line = std::string("a connection failed: ") + what] {
        try {
          context_.log(Severity::kWarning, line);
        } catch (...) {}
      });
    } catch (...) {}  // no memory even for the log
  }

  void admit(tcp::socket socket) {
    const auto most = static_cast<int64_t>(options_.max_connections);
    if (metrics_.connections >= most + kReserve)
      return turnAway(std::move(socket), RefusedFor::kFull, fmt::format("there are {} connections already", most));
    const std::string address = addressOf(socket);
    const auto from = context_.connections_from.find(networkOf(address));
    if (from != context_.connections_from.end() && !context_.gate.isTrusted(address) &&
        from->second >= options_.max_connections_per_address)
      return turnAway(std::move(socket), RefusedFor::kAddress,
                      fmt::format("there are {} connections from its address already", from->second));
    ErrorOf ignored;  // a socket that was closed meanwhile fails at the first read
    socket.set_option(tcp::no_delay(true), ignored);
    socket.set_option(net::socket_base::send_buffer_size(static_cast<int>(options_.send_buffer_bytes)), ignored);
    serveHttp(std::move(socket), metrics_.connections >= most ? Admission::kReserve : Admission::kWhole, context_);
  }

  void admitOperator(tcp::socket socket) {
    if (metrics_.metrics_connections < kMaxMetricsConnections)
      serveHttp(std::move(socket), Admission::kMetrics, context_);
  }

  // Says why.
  void turnAway(tcp::socket socket, RefusedFor reason, const std::string& why) {
    metrics_.count(reason);
    context_.log(Severity::kDebug, "turned a connection away: " + why);
    if (context_.tls) return;  // it would not be understood
    static constexpr std::string_view kBody = "The server is full. Try again in a while\n";
    static const std::string reply = [] {
      std::string rules;
      for (const auto& [name, value] : kRules) rules += fmt::format("{}: {}\r\n", name, value);
      return fmt::format(
          "HTTP/1.1 503 Service Unavailable\r\nServer: foreland\r\nRetry-After: 5\r\nConnection: close\r\n{}"
          "Content-Type: text/plain; charset=utf-8\r\nContent-Length: {}\r\n\r\n{}",
          rules, kBody.size(), kBody);
    }();
    sayAndClose(socket, reply);
  }

  // HAProxy connects every few seconds and reads one line. "ready" takes back the "drain" of a server of this name
  // before.
  void tellWeight(tcp::socket socket) {
    const bool is_leaving = is_stopping_ || context_.is_draining;
    sayAndClose(socket, is_leaving ? "drain\n" : fmt::format("ready {}%\n", Load::weightPercent(load())));
  }

  // Whether it is read is not waited for.
  static void sayAndClose(tcp::socket& socket, std::string_view line) {
    ErrorOf ignored;
    socket.non_blocking(true, ignored);
    socket.write_some(net::buffer(line), ignored);
    socket.shutdown(tcp::socket::shutdown_send, ignored);
  }

  // Why no further viewer should come; empty if one may.
  // `asking`: how many of the connections ask for that.
  std::string unready(int64_t asking) const {
    if (is_stopping_ || context_.is_draining) return "The server stops.";
    if (metrics_.connections - asking >= static_cast<int64_t>(options_.max_connections)) return "The server is full.";
    return load() > Load::kBusy ? "The server is overloaded." : "";
  }

  // Of what limits the server, its workers, the thread for connections or the processors: the share of its time that
  // was used of late.
  double load() const { return std::max({host_.load(), use_.thread().last(), use_.process().last()}); }

  void watch() {
    watch_.start(std::min(Duration{options_.idle_timeout.us / 4}, Duration::seconds(1)), [this] {
      const Time now = clock_();
      use_.update(now);
      const auto everyone = everyViewer();
      for (const auto& viewer : everyone) viewer->check(now);
      relieve(everyone, now);
      if (memory_return_.isDue(context_.viewers.size(), now))
        pool_.submit({.release = now, .deadline = now + Duration::seconds(10), .is_costly = true},
                     [](size_t) { MemoryReturn::run(); });
      return true;
    });
  }

  // Where a balancer is told how busy this server is, who has to leave finds another one.
  void relieve(std::span<const std::shared_ptr<ViewerConnection>> everyone, Time now) {
    if (!options_.agent_listen || context_.is_draining) return;
    std::vector<Rebalance::Viewer> viewers;
    for (const auto& viewer : everyone)
      viewers.push_back({viewer->isMigrating() ? 0 : viewer->cost(), viewer->openedAt()});
    const Rebalance::Use use{.load = load(),
                             .workers = pool_.threadCount(),
                             .connections = use_.thread().mean(),
                             .processors = use_.process().mean(),
                             .fleet = context_.fleet.at(now)};
    for (const size_t i : rebalance_.choose(viewers, use, now)) {
      everyone[i]->migrate();
      ++metrics_.migrated;
    }
  }

  void beginDrain(Duration most) {
    context_.is_draining = true;
    drain_loop_.start(Duration::milliseconds(10), [this, most] { return continueDrain(most); });
  }

  // Whether it is to go on.
  bool continueDrain(Duration most) {
    const Time now = clock_();
    if (!drain_) {
      drain_.emplace(context_, now, most);
      context_.log(Severity::kInfo, fmt::format("hands {} viewers over", context_.viewers.size()));
    }
    drain_->step(now);
    if (!drain_->isOver(now)) return true;
    drained_.set_value();
    return false;
  }

  // Polls for their leave, for that happens once only, and no connection has to report that it was the last.
  void takeLeave() {
    is_stopping_ = true;
    listener_.close();
    metrics_listener_.close();
    agent_listener_.close();
    watch_.stop();
    guarded([this] {
      for (const auto& viewer : everyViewer())
        viewer->leave(boost::beast::websocket::close_code::going_away, "the server stops");
    });
    stop_by_ = std::chrono::steady_clock::now() + chrono(options_.stop_grace);
    leave_loop_.start(Duration::milliseconds(5), [this] {
      if (!context_.viewers.empty() && std::chrono::steady_clock::now() < stop_by_) return true;
      io_.stop();
      return false;
    });
  }

  // Iterates over a copy, because a call may remove its viewer from the set.
  std::vector<std::shared_ptr<ViewerConnection>> everyViewer() const {
    return {context_.viewers.begin(), context_.viewers.end()};
  }

  std::string metricsText() const {
    return renderPrometheus(metrics_, {.version = options_.version,
                                       .uptime_s = (clock_() - started_at_).toSeconds(),
                                       .process = processMetrics(),
                                       .threads = pool_.threadCount(),
                                       .load = host_.load(),
                                       .io_load = use_.thread().last(),
                                       .processor_load = use_.process().last(),
                                       .fleet_load = context_.fleet.at(clock_()),
                                       .queue_depth = pool_.queueDepth(),
                                       .lateness = &pool_.lateness(),
                                       .coded_pages = codedPages(),
                                       .store = storeCounts(),
                                       .viewers_by_scene = viewersByScene()});
  }

  // Of all scenes whose pages are coded.
  std::optional<CodedPageCounts> codedPages() const {
    std::optional<CodedPageCounts> sum;
    for (const std::shared_ptr<const World>& world : worlds_) {
      const terrain::CodedPages* pages = world->hierarchy.scene().coded();
      if (!pages) continue;
      if (!sum) sum.emplace();
      const terrain::PageCache::Counts counts = pages->counts();
      sum->held_bytes += counts.held * terrain::kGroupBytes;
      sum->inflated += counts.inflated;
      sum->woken += counts.woken;
      sum->evicted += counts.evicted;
      sum->damaged += pages->damagedGroups();
    }
    return sum;
  }

  // Of all scenes at a distance.
  std::optional<StoreCounts> storeCounts() const {
    std::optional<StoreCounts> sum;
    for (const std::shared_ptr<const World>& world : worlds_) {
      const terrain::PageSupply* supply = world->hierarchy.scene().supply();
      if (!supply) continue;
      if (!sum) sum.emplace();
      const terrain::ChunkCache::Counts counts = supply->cache().counts();
      const uint64_t each = supply->cache().sums().chunk_bytes;
      sum->there_bytes += counts.there * each;
      sum->held_bytes += counts.held * each;
      sum->capacity_bytes += counts.capacity * each;
      sum->wished += counts.wished;
      sum->uses += counts.uses;
      sum->fetched += counts.fetched;
      sum->fetched_bytes += counts.fetched_bytes;
      sum->evicted += counts.evicted;
      sum->failures[0] += counts.failed;
      sum->failures[1] += counts.unsound;
      sum->failures[2] += counts.no_room;
    }
    return sum;
  }

  std::vector<std::pair<std::string, int64_t>> viewersByScene() const {
    std::vector<std::pair<std::string, int64_t>> all;
    const std::vector<int64_t> sessions = host_.sessionsByWorld();
    for (size_t i = 0; i < site_.scenes.size(); ++i) all.emplace_back(site_.scenes[i], sessions[i]);
    return all;
  }

  const ServeOptions options_;
  const Clock clock_;
  const std::vector<std::shared_ptr<const World>> worlds_;
  const Time started_at_ = clock_();
  Metrics metrics_;
  std::map<std::string, size_t> connections_from_;
  Pool pool_;
  SessionHost host_;
  HttpSite site_, metrics_site_;
  Gate gate_;
  net::io_context io_{1};  // its handlers hold the connections, whose destructors use the members above
  // It runs until it is stopped, also where a failure left it without anything to wait for.
  const net::executor_work_guard<net::io_context::executor_type> work_ = net::make_work_guard(io_);
  ServerContext context_;
  Listener listener_{io_, eventsOf([this](tcp::socket socket) { admit(std::move(socket)); })};
  Listener metrics_listener_{io_, eventsOf([this](tcp::socket socket) { admitOperator(std::move(socket)); })};
  Listener agent_listener_{io_, eventsOf([this](tcp::socket socket) { tellWeight(std::move(socket)); })};
  Repeater watch_{io_, [this](const char* what) { failed(what); }};
  Repeater drain_loop_{io_, [this](const char* what) { failed(what); }};
  Repeater leave_loop_{io_, [this](const char* what) { failed(what); }};
  MemoryReturn memory_return_;  // I/O thread
  ProcessorUse use_;            // I/O thread
  Rebalance rebalance_;         // I/O thread
  std::optional<Drain> drain_;  // I/O thread
  std::promise<void> drained_;
  std::chrono::steady_clock::time_point stop_by_;
  bool is_stopping_ = false;  // I/O thread
  std::jthread io_thread_;
};

Result<std::unique_ptr<Server>> Server::listen(std::shared_ptr<const World> world, ServeOptions options, Clock clock) {
  std::vector<std::shared_ptr<const World>> worlds = {std::move(world)};
  return listen(std::move(worlds), {}, std::move(options), std::move(clock));
}

Result<std::unique_ptr<Server>> Server::listen(std::vector<ServedScene> scenes, ServeOptions options, Clock clock) {
  std::vector<std::shared_ptr<const World>> worlds;
  std::vector<std::string> names;
  for (ServedScene& scene : scenes) {
    names.push_back(std::move(scene.name));
    worlds.push_back(std::move(scene.world));
  }
  if (Status status = checkSceneNames(names); !status.ok()) return status.error();
  return listen(std::move(worlds), std::move(names), std::move(options), std::move(clock));
}

Result<std::unique_ptr<Server>> Server::listen(std::vector<std::shared_ptr<const World>> worlds,
                                               std::vector<std::string> names, ServeOptions options, Clock clock) {
  StaticFiles files;
  if (!options.web.empty()) {
    auto loaded = StaticFiles::load(options.web);
    if (!loaded) return loaded.error();
    files = std::move(*loaded);
  }
  for (auto& [path, body] : options.files) files.add(path, std::move(body));
  options.files.clear();
  auto impl = std::make_unique<Impl>(std::move(worlds), std::move(names), std::move(options), std::move(files),
                                     std::move(clock));
  if (Status status = impl->listen(); !status.ok()) return status.error();
  impl->start();
  return std::unique_ptr<Server>(new Server(std::move(impl)));
}

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Server::~Server() = default;
uint16_t Server::port() const { return impl_->port(); }
uint16_t Server::metricsPort() const { return impl_->metricsPort(); }
uint16_t Server::agentPort() const { return impl_->agentPort(); }
Status Server::reloadTls() { return impl_->loadTls(); }
void Server::drain(Duration most) { impl_->drain(most); }
void Server::stop() { impl_->stop(); }

}  // namespace foreland::server
