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
      : counts_(Time::seconds(options.run_in_s)),
        end_(counts_ + Duration::seconds(options.leg_s)),
        latency_(Duration::seconds(options.round_trip_s / 2)),
        session_(world, {}),
        light_(options.request, flight) {
    send(light_.connect(), Time{});
    if (auto path = light_.announce(Time{}, end_ + Duration::seconds(5))) send(std::move(*path), Time{});
  }

  Time end() const { return end_; }
  uint64_t hash() const { return hash_.value(); }
  // One tick. The scratch is any.
  void fly(Time now, server::SessionScratch& scratch, ServerFlight& figures) {
    if (now.us % LightViewer::kPoseInterval.us == 0)
      if (auto pose = light_.pose(now)) send(std::move(*pose), now);
    for (; !up_.empty() && up_.front().first <= now; up_.pop_front())
      CHECK_TRUE(session_.receive(up_.front().second, now).ok());
    for (; !down_.empty() && down_.front().first <= now; down_.pop_front())
      (void)light_.receive(down_.front().second, now);
    if (const auto due = session_.due(); due && due->release <= now) step(now, scratch, figures);
  }

 private:
  void send(Bytes message, Time now) { up_.emplace_back(now + latency_, std::move(message)); }

  void step(Time now, server::SessionScratch& scratch, ServerFlight& figures) {
    const bool counts = now >= counts_;
    const server::SessionStatistics before = session_.statistics();
    out_.clear();
    if (counts)
      stepThatCounts(session_, now, scratch, out_);
    else
      session_.step(now, scratch, out_);
    session_.noteComputeTime(kTaken);
    size_t bytes = 0;
    for (Bytes& message : out_) {
      bytes += message.size();
      for (uint8_t byte : message) hash_.add(byte);
      down_.emplace_back(now + kTaken + latency_, std::move(message));
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

  const Time counts_, end_;
  const Duration latency_;
  server::Session session_;
  LightViewer light_;
  std::deque<std::pair<Time, Bytes>> up_, down_;
  std::vector<Bytes> out_;
  Fnv1a hash_;
};

}  // namespace

ServerFlight flyForServer(const std::shared_ptr<const server::World>& world, std::shared_ptr<const proto::Path> path,
                          const ServerFlightOptions& options) {
  ServerFlight figures;
  Fnv1a hash;
  server::SessionScratch scratch;
  std::deque<Leg> legs;
  const auto fly = [&] {
    for (Time now; now < legs.front().end(); now = now + kTick)
      for (Leg& leg : legs) leg.fly(now, scratch, figures);
    for (const Leg& leg : legs) hash.addWord(leg.hash());
    legs.clear();
  };
  const Duration apart{(path->end() - path->start).us / options.legs};
  for (int i = 0; i < options.legs; ++i) {
    legs.emplace_back(world, LightViewer::Flight{path, apart * i, {}}, options);
    if (!options.side_by_side || i + 1 == options.legs) fly();
  }
  figures.hash = hash.value();
  return figures;
}

}  // namespace foreland::lab
