#include "bench/load/real_load.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <latch>
#include <numeric>
#include <thread>
#include <utility>

#include "bench/load/load_cast.h"
#include "bench/load/server_counts.h"
#include "bench/programs/running_program.h"
#include "bench/proxy/proxy.h"
#include "bench/timing.h"
#include "client/fly/net/web_socket_client.h"
#include "server/net/steady_clock.h"

namespace foreland::bench {

namespace {

using client::WebSocketClient;
using WallClock = WebSocketClient::Clock;

std::chrono::microseconds chrono(Time t) { return std::chrono::microseconds(t.us); }

// All viewers are connected before time begins, which is then the same for all.
struct Start {
  explicit Start(size_t viewers) : connected(static_cast<std::ptrdiff_t>(viewers)) {}
  std::latch connected, go{1};
  WallClock::time_point zero;

  Time now() const { return {std::chrono::duration_cast<std::chrono::microseconds>(WallClock::now() - zero).count()}; }
};

// One viewer's flight, as LoadSimulation flies it; a thread of its own.
class RealViewer {
 public:
  RealViewer(const LoadViewer& viewer, Time begin, Time end)
      : light_(viewer.cast.request, viewer.cast.flight),
        comes_(viewer.comes),
        clock_(viewer.clock),
        begin_(begin),
        end_(end) {}

  void fly(const std::string& url, Start& start) {
    auto connection = WebSocketClient::connect(url, std::chrono::seconds(10));
    start.connected.count_down();
    start.go.wait();
    status_ = connection.ok() ? fly(*connection, start) : Status(connection.error());
    if (status_.ok()) connection->close();
  }
  const Status& status() const { return status_; }
  const ViewerTally& tally() const { return tally_; }

 private:
  Status fly(WebSocketClient& connection, const Start& start) {
    const Duration interval = light_.request().keyframe_interval;
    const auto runUntil = [&](Time t) {
      return connection.run(start.zero + chrono(t), [&](ByteSpan message) {
        tally_.add(light_.receive(message, start.now() + clock_), message.size(), begin_ + clock_ + interval,
                   end_ + clock_ - interval);
        return Status();
      });
    };
    if (Status s = runUntil(comes_); !s.ok()) return s;
    connection.send(light_.connect());
    if (auto path = light_.announce(comes_ + clock_, end_ + clock_)) connection.send(std::move(*path));
    for (Time pose = comes_ + kFirstPose; pose < end_; pose = pose + LightViewer::kPoseInterval) {
      if (Status s = runUntil(pose); !s.ok()) return s;
      if (auto message = light_.pose(start.now() + clock_)) connection.send(std::move(*message));
    }
    return runUntil(end_);
  }

  LightViewer light_;
  Time comes_;
  Duration clock_;
  Time begin_, end_;
  ViewerTally tally_;
  Status status_;
};

// The port in the line in which a server prints its address.
Result<uint16_t> portOf(const std::string& line) {
  const size_t at = line.rfind(':');
  uint16_t port = 0;
  if (at != std::string::npos) std::from_chars(line.data() + at + 1, line.data() + line.size(), port);
  if (port == 0) return Error{ErrorCode::kIo, "`foreland serve` did not start; is it built beside `foreland bench`?"};
  return port;
}

Result<std::unique_ptr<Proxy>> proxyFor(const std::vector<LoadViewer>& cast, uint16_t port) {
  ProxyOptions options;
  options.to = {"127.0.0.1", port};
  for (const LoadViewer& viewer : cast)
    options.doors.push_back({{"127.0.0.1", 0}, viewer.cast.links, viewer.link_seed});
  return Proxy::open(std::move(options), server::steadyNow);
}

// The server's counts of the measured time.
Status watch(const Start& start, uint16_t port, Time begin, Time end, const LoadOptions& options, RealLoad& real) {
  std::this_thread::sleep_until(start.zero + chrono(begin));
  const auto before = readCounts(port);
  std::this_thread::sleep_until(start.zero + chrono(end));
  const auto after = readCounts(port);
  if (!before) return before.error();
  if (!after) return after.error();
  real.server_keyframes = static_cast<uint64_t>(after->keyframes - before->keyframes);
  real.server_missed = static_cast<uint64_t>(after->late_keyframes - before->late_keyframes);
  real.used = (after->cpu_s - before->cpu_s) / (options.seconds * static_cast<double>(options.workers));
  return {};
}

}  // namespace

Status checkReal(const LoadOptions& options) {
  const auto refuse = [](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, "in real time " + what + ", which is how `foreland serve` runs"};
  };
  if (options.cluster.servers > 1) return refuse("there is one server");
  if (options.policy != LoadPolicy::kFair) return refuse("the policy is fair");
  if (options.start != LoadStart::kEarly) return refuse("starts are early");
  if (options.queues != LoadQueues::kShared) return refuse("the queue is shared");
  return {};
}

Result<RealLoad> runRealLoad(const terrain::Scene& scene, const LoadOptions& options,
                             const std::filesystem::path& serve, const std::filesystem::path& scene_file) {
  const Time begin = Time{} + kLoadRunIn, end = begin + Duration::seconds(options.seconds);
  std::vector<size_t> roles(options.viewers);
  std::iota(roles.begin(), roles.end(), 0);
  const std::vector<LoadViewer> cast = viewersOf(LoadTours(scene), options, roles);

  auto server = RunningProgram::start({serve, scene_file, "--threads", std::to_string(options.workers), "--listen",
                                       "127.0.0.1:0", "--log-level", "off"});
  if (!server) return server.error();
  const auto port = portOf(server->readLine());
  if (!port) return port.error();
  const auto proxy = proxyFor(cast, *port);
  if (!proxy) return proxy.error();

  RealLoad real;
  Start start(cast.size());
  std::vector<RealViewer> viewers;
  for (const LoadViewer& viewer : cast) viewers.emplace_back(viewer, begin, end);
  Status watched;
  {
    std::vector<std::jthread> threads;
    for (size_t i = 0; i < viewers.size(); ++i)
      threads.emplace_back([&viewers, &start, i, url = "ws://127.0.0.1:" + std::to_string((*proxy)->port(i))] {
        viewers[i].fly(url, start);
      });
    start.connected.wait();
    start.zero = WallClock::now() + std::chrono::milliseconds(100);
    start.go.count_down();
    watched = watch(start, *port, begin, end, options, real);
  }
  for (const RealViewer& viewer : viewers) {
    if (!viewer.status().ok()) return viewer.status().error();
    real.viewers.push_back(viewer.tally());
  }
  if (!watched.ok()) return watched.error();
  return real;
}

std::vector<Agreement> agreementOf(const LoadRun& virtual_time, const RealLoad& real_time) {
  struct Sums {
    explicit Sums(const std::vector<ViewerTally>& viewers) {
      for (const ViewerTally& v : viewers) {
        keyframes += static_cast<double>(v.keyframes), late += static_cast<double>(v.late);
        bytes += static_cast<double>(v.bytes) / static_cast<double>(viewers.size());
        lateness_ms.insert(lateness_ms.end(), v.lateness_ms.begin(), v.lateness_ms.end());
      }
    }
    double keyframes = 0, late = 0, bytes = 0;
    std::vector<double> lateness_ms;
  };
  const Sums a(virtual_time.viewers), b(real_time.viewers);
  const LoadFigures& f = virtual_time.figures;
  return {{"keyframes", a.keyframes, b.keyframes},
          {"late", a.late, b.late},
          {"lateness_p50_ms", quantile(a.lateness_ms, 0.5), quantile(b.lateness_ms, 0.5)},
          {"lateness_p99_ms", quantile(a.lateness_ms, 0.99), quantile(b.lateness_ms, 0.99)},
          {"lateness_max_ms", quantile(a.lateness_ms, 1), quantile(b.lateness_ms, 1)},
          {"bytes_per_viewer", a.bytes, b.bytes},
          // After a jump a keyframe is due at once, and missed by the server's count.
          {"server_keyframes", static_cast<double>(f.keyframes + f.at_once),
           static_cast<double>(real_time.server_keyframes)},
          {"server_missed", static_cast<double>(f.missed + f.at_once), static_cast<double>(real_time.server_missed)},
          {"used", f.utilisation, real_time.used}};
}

double largestByteDifference(const LoadRun& virtual_time, const RealLoad& real_time) {
  double largest = 0;
  for (size_t i = 0; i < real_time.viewers.size(); ++i) {
    const auto expected = static_cast<double>(virtual_time.viewers[i].bytes),
               got = static_cast<double>(real_time.viewers[i].bytes);
    largest = std::max(largest, std::abs(got - expected) / std::max(expected, 1.0));
  }
  return largest;
}

}  // namespace foreland::bench
