#include "lab/load/server_flight.h"

#include <deque>
#include <utility>

#include "base/check.h"
#include "base/fnv1a.h"
#include "lab/load/light_viewer.h"
#include "server/session/session.h"

namespace foreland::lab {

// The function that instruction counters are told to watch (lab/README.md).
[[gnu::noinline]] void stepThatCounts(server::Session& session, Time now, server::SessionScratch& scratch,
                                      std::vector<Bytes>& out) {
  session.step(now, scratch, out);
}

namespace {

constexpr Duration kTick = Duration::milliseconds(5), kTaken = Duration::milliseconds(2);

// A session and its viewer, on one leg.
class Leg {
 public:
  Leg(const std::shared_ptr<const server::World>& world, const LightViewer::Flight& flight,
      const ServerFlightOptions& options)
      : options_(options), session_(world, {}), light_(options.request, flight) {}

  void fly(ServerFlight& figures, Fnv1a& hash) {
    const Time counts = Time::seconds(options_.run_in_s), end = counts + Duration::seconds(options_.leg_s);
    const Duration latency = Duration::seconds(options_.round_trip_s / 2);
    send(light_.connect(), Time{} + latency);
    if (auto path = light_.announce(Time{}, end + Duration::seconds(5))) send(std::move(*path), Time{} + latency);
    for (Time now; now < end; now = now + kTick) {
      if (now.us % LightViewer::kPoseInterval.us == 0)
        if (auto pose = light_.pose(now)) send(std::move(*pose), now + latency);
      for (; !up_.empty() && up_.front().first <= now; up_.pop_front())
        CHECK_TRUE(session_.receive(up_.front().second, now).ok());
      for (; !down_.empty() && down_.front().first <= now; down_.pop_front())
        (void)light_.receive(down_.front().second, now);
      if (const auto due = session_.due(); due && due->release <= now) step(now, latency, now >= counts, figures, hash);
    }
  }

 private:
  void send(Bytes message, Time arrives) { up_.emplace_back(arrives, std::move(message)); }

  void step(Time now, Duration latency, bool counts, ServerFlight& figures, Fnv1a& hash) {
    const server::SessionStatistics before = session_.statistics();
    out_.clear();
    if (counts)
      stepThatCounts(session_, now, scratch_, out_);
    else
      session_.step(now, scratch_, out_);
    session_.noteComputeTime(kTaken);
    size_t bytes = 0;
    for (Bytes& message : out_) {
      bytes += message.size();
      for (uint8_t byte : message) hash.add(byte);
      down_.emplace_back(now + kTaken + latency, std::move(message));
    }
    if (!out_.empty()) session_.onDrained(now + kTaken);
    if (counts) count(before, bytes, figures);
  }
  void count(const server::SessionStatistics& before, size_t bytes, ServerFlight& figures) const {
    const server::SessionStatistics& after = session_.statistics();
    if (after.keyframes == before.keyframes) return;
    figures.keyframes += 1;
    figures.nodes += after.section_nodes;
    figures.tested += after.nodes_tested - before.nodes_tested;
    figures.changed += after.nodes_added + after.nodes_removed - before.nodes_added - before.nodes_removed;
    figures.measured += after.nodes_measured - before.nodes_measured;
    figures.bytes += bytes;
    figures.region_m += session_.keyframe().region_radius_m;
    figures.region_rad += session_.keyframe().region_angle_rad;
  }

  const ServerFlightOptions& options_;
  server::Session session_;
  server::SessionScratch scratch_;
  LightViewer light_;
  std::deque<std::pair<Time, Bytes>> up_, down_;
  std::vector<Bytes> out_;
};

}  // namespace

ServerFlight flyForServer(const std::shared_ptr<const server::World>& world, std::shared_ptr<const proto::Path> path,
                          const ServerFlightOptions& options) {
  ServerFlight figures;
  Fnv1a hash;
  const Duration apart{(path->end() - path->start).us / options.legs};
  for (int i = 0; i < options.legs; ++i) Leg(world, {path, apart * i, {}}, options).fly(figures, hash);
  figures.hash = hash.value();
  return figures;
}

}  // namespace foreland::lab
