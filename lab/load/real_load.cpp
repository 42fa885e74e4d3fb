#include "lab/load/real_load.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <iterator>
#include <thread>
#include <utility>

#include "base/quantile.h"
#include "lab/load/load_cast.h"
#include "lab/load/real_viewer.h"
#include "lab/load/server_counts.h"
#include "lab/programs/running_program.h"
#include "lab/proxy/proxy.h"
#include "server/net/steady_clock.h"

namespace foreland::lab {

namespace {

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

// A server and the way to it, with a door for each viewer.
struct RealServer {
  RunningProgram program;
  uint16_t port = 0;
  std::unique_ptr<Proxy> proxy;
  std::string url(size_t viewer) const { return "ws://127.0.0.1:" + std::to_string(proxy->port(viewer)); }
};

Result<RealServer> startServer(const std::vector<LoadViewer>& cast, const LoadOptions& options,
                               const std::filesystem::path& serve, const std::filesystem::path& scene_file) {
  auto program = RunningProgram::start({serve, scene_file, "--threads", std::to_string(options.workers), "--listen",
                                        "127.0.0.1:0", "--occlusion", name(options.occlusion), "--log-level", "off"});
  if (!program) return program.error();
  const auto port = portOf(program->readLine());
  if (!port) return port.error();
  auto proxy = proxyFor(cast, *port);
  if (!proxy) return proxy.error();
  return RealServer{std::move(*program), *port, std::move(*proxy)};
}

// The server's counts of the measured time.
Status watch(const RealStart& start, uint16_t port, Time begin, Time end, const LoadOptions& options, RealLoad& real) {
  std::this_thread::sleep_until(start.at(begin));
  const auto before = readCounts(port);
  std::this_thread::sleep_until(start.at(end));
  const auto after = readCounts(port);
  if (!before) return before.error();
  if (!after) return after.error();
  real.server_keyframes = static_cast<uint64_t>(after->keyframes - before->keyframes);
  real.server_missed = static_cast<uint64_t>(after->late_keyframes - before->late_keyframes);
  real.used = (after->cpu_s - before->cpu_s) / (options.seconds * static_cast<double>(options.workers));
  return {};
}

// What happens to the servers, when it does.
void happen(const RealStart& start, Time begin, const ClusterOptions& cluster, std::vector<RealServer>& servers) {
  for (const ServerEvent& event : cluster.events) {
    std::this_thread::sleep_until(start.at(begin + Duration::seconds(event.at_s)));
    RunningProgram& program = servers[event.server].program;
    event.what == ServerEvent::What::kDrain ? program.ask() : program.kill();
  }
}

// By turns, as LoadSimulation places them with round-robin.
std::vector<RealViewer> viewersFor(const std::vector<LoadViewer>& cast, Time begin, Time end,
                                   const std::vector<RealServer>& servers) {
  std::vector<RealViewer> viewers;
  for (size_t i = 0; i < cast.size(); ++i) {
    std::vector<std::string> urls;
    for (size_t s = 0; s < servers.size(); ++s) urls.push_back(servers[(i + s) % servers.size()].url(i));
    viewers.emplace_back(cast[i], begin, end, std::move(urls));
  }
  return viewers;
}

void sumUpMoves(const std::vector<RealViewer>& viewers, RealLoad& real) {
  for (const RealViewer& viewer : viewers)
    real.moves.insert(real.moves.end(), viewer.moves().begin(), viewer.moves().end());
  real.cluster.emplace();
  sumUp(real.moves, *real.cluster);
}

Status refuse(const std::string& what) {
  return Error{ErrorCode::kInvalidArgument, "in real time " + what + ", which is how `foreland serve` runs"};
}

// Two servers of which one ends: whoever is on it has one to go to, so nothing needs a balancer.
Status checkRealCluster(const ClusterOptions& cluster) {
  if (cluster.servers < 2) return {};
  const bool is_one_end = cluster.events.size() == 1 && cluster.events[0].what != ServerEvent::What::kJoin;
  if (cluster.servers == 2 && is_one_end && cluster.balance == Balance::kRoundRobin) return {};
  return Error{ErrorCode::kInvalidArgument,
               "in real time there is one server, or there are two of which one is drained or fails (--servers 2 "
               "--drain 1@5, or --fail), with --balance round-robin"};
}

}  // namespace

Status checkReal(const LoadOptions& options) {
  if (!(options.order_command.empty() && options.cluster.balance_command.empty() && options.predictor_command.empty() &&
        options.link_command.empty()))
    return Error{ErrorCode::kInvalidArgument, "in real time no program takes part by --...-command"};
  if (Status s = checkRealCluster(options.cluster); !s.ok()) return s;
  if (options.neighbour > 0) return refuse("no neighbour takes processors");
  if (options.policy != LoadPolicy::kFair) return refuse("the policy is fair");
  if (options.start != LoadStart::kEarly) return refuse("starts are early");
  if (options.queues != LoadQueues::kShared) return refuse("the queue is shared");
  if (options.slack_ms != LoadOptions{}.slack_ms) return refuse("the slack is what servers have");
  return {};
}

Result<RealLoad> runRealLoad(const terrain::Scene& scene, const LoadOptions& options,
                             const std::filesystem::path& serve, const std::filesystem::path& scene_file) {
  const Time begin = Time::seconds(options.run_in_s), end = begin + Duration::seconds(options.seconds);
  Rng chance(options.seed + 1);
  const std::vector<LoadViewer> cast = viewersOf(LoadTours(scene), options, rolesOf(options, chance));
  std::vector<RealServer> servers;
  for (size_t s = 0; s < options.cluster.servers; ++s) {
    auto server = startServer(cast, options, serve, scene_file);
    if (!server) return server.error();
    servers.push_back(std::move(*server));
  }

  RealLoad real;
  RealStart start(cast.size());
  std::vector<RealViewer> viewers = viewersFor(cast, begin, end, servers);
  Status watched;
  {
    std::vector<std::jthread> threads;
    for (RealViewer& viewer : viewers) threads.emplace_back([&viewer, &start] { viewer.fly(start); });
    start.connected.wait();
    start.zero = RealStart::Clock::now() + std::chrono::milliseconds(100);
    start.go.count_down();
    if (servers.size() == 1)
      watched = watch(start, servers[0].port, begin, end, options, real);
    else
      happen(start, begin, options.cluster, servers);
  }
  for (const RealViewer& viewer : viewers) {
    if (!viewer.status().ok()) return viewer.status().error();
    real.viewers.push_back(viewer.tally());
  }
  if (!watched.ok()) return watched.error();
  if (servers.size() > 1) sumUpMoves(viewers, real);
  return real;
}

namespace {

void addMoves(const ClusterFigures& a, const ClusterFigures& b, std::vector<Agreement>& all) {
  const auto count = [](uint64_t n) { return static_cast<double>(n); };
  const Agreement moves[] = {{"handed_over", count(a.migrated), count(b.migrated)},
                             {"lost", count(a.lost), count(b.lost)},
                             {"afresh", count(a.afresh), count(b.afresh)},
                             {"move_gap_p50_ms", a.move_gap_p50_ms, b.move_gap_p50_ms},
                             {"move_gap_max_ms", a.move_gap_max_ms, b.move_gap_max_ms},
                             {"lost_gap_p50_ms", a.lost_gap_p50_ms, b.lost_gap_p50_ms},
                             {"lost_gap_max_ms", a.lost_gap_max_ms, b.lost_gap_max_ms},
                             {"move_up_mean_bytes", a.move_up_mean, b.move_up_mean},
                             {"move_up_max_bytes", a.move_up_max, b.move_up_max},
                             {"move_down_mean_bytes", a.move_down_mean, b.move_down_mean},
                             {"move_down_max_bytes", a.move_down_max, b.move_down_max}};
  all.insert(all.end(), std::begin(moves), std::end(moves));
}

}  // namespace

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
  std::vector<Agreement> all{{"keyframes", a.keyframes, b.keyframes},
                             {"late", a.late, b.late},
                             {"lateness_p50_ms", quantile(a.lateness_ms, 0.5), quantile(b.lateness_ms, 0.5)},
                             {"lateness_p99_ms", quantile(a.lateness_ms, 0.99), quantile(b.lateness_ms, 0.99)},
                             {"lateness_max_ms", quantile(a.lateness_ms, 1), quantile(b.lateness_ms, 1)},
                             {"bytes_per_viewer", a.bytes, b.bytes}};
  if (virtual_time.cluster && real_time.cluster) {
    addMoves(virtual_time.cluster->figures, *real_time.cluster, all);
    return all;
  }
  // After a jump a keyframe is due at once, and missed by the server's count.
  all.push_back({"server_keyframes", static_cast<double>(f.keyframes + f.at_once),
                 static_cast<double>(real_time.server_keyframes)});
  all.push_back(
      {"server_missed", static_cast<double>(f.missed + f.at_once), static_cast<double>(real_time.server_missed)});
  all.push_back({"used", f.utilisation, real_time.used});
  return all;
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

}  // namespace foreland::lab
