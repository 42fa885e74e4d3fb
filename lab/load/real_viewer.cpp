#include "lab/load/real_viewer.h"

#include <thread>
#include <utility>

namespace foreland::lab {

namespace {

using client::LostBy;

constexpr std::chrono::seconds kTimeout{10};
constexpr int64_t kFirstWait_us = 200'000;  // as `foreland fly`, and LoadSimulation

void sleep(Duration d) { std::this_thread::sleep_for(std::chrono::microseconds(d.us)); }

}  // namespace

RealViewer::RealViewer(const LoadViewer& viewer, Time begin, Time end, std::vector<std::string> urls)
    : light_(viewer.cast.request, viewer.cast.flight,
             urls.size() > 1 ? LightViewer::Holds::kSections : LightViewer::Holds::kNothing),
      comes_(viewer.comes),
      clock_(viewer.clock),
      round_trip_(viewer.cast.links.up.latency + viewer.cast.links.down.latency),
      begin_(begin),
      end_(end),
      urls_(std::move(urls)),
      chance_(viewer.link_seed),
      next_pose_(comes_ + kFirstPose) {}

Result<RealViewer::Connection> RealViewer::connect() { return Connection::connect(urls_[server_], kTimeout); }

void RealViewer::fly(RealStart& start) {
  auto connection = connect();
  start.connected.count_down();
  start.go.wait();
  status_ = connection.ok() ? fly(*connection, start) : Status(connection.error());
  if (status_.ok()) connection->close();
}

Status RealViewer::fly(Connection& connection, const RealStart& start) {
  if (Status s = connection.run(start.at(comes_), [](ByteSpan) { return Status(); }); !s.ok()) return s;
  greet(connection);
  if (auto path = light_.announce(comes_ + clock_, end_ + clock_)) connection.send(std::move(*path));
  while (start.now() < end_) {
    Status status = stay(connection, start);
    if (!status.ok() && urls_.size() > 1) status = moveOn(connection, start);
    if (!status.ok()) return status;
  }
  return {};
}

void RealViewer::greet(Connection& connection) {
  Bytes request = light_.connect();
  move_.up = request.size();
  connection.send(std::move(request));
}

// Until the end, or until the connection is lost.
Status RealViewer::stay(Connection& connection, const RealStart& start) {
  const auto runUntil = [&](Time t) {
    return connection.run(start.at(t), [&](ByteSpan message) {
      take(connection, message, start.now());
      return Status();
    });
  };
  for (; next_pose_ < end_; next_pose_ = next_pose_ + LightViewer::kPoseInterval) {
    if (Status s = runUntil(next_pose_); !s.ok()) return s;
    if (auto message = light_.pose(start.now() + clock_)) connection.send(std::move(*message));
  }
  return runUntil(end_);
}

// On loopback nobody waits for TCP's round trip, as one would over the link; here it is waited for.
Status RealViewer::moveOn(Connection& connection, const RealStart& start) {
  const bool is_lost = connection.lostBy() != LostBy::kMigrate;
  moving_ = is_lost ? MoveCause::kLost : MoveCause::kDrained;
  if (is_lost) sleep(Duration{static_cast<int64_t>(chance_.below(kFirstWait_us))});
  sleep(round_trip_);
  server_ = (server_ + 1) % urls_.size();
  auto next = connect();
  if (!next) return next.error();
  connection = std::move(*next);
  move_ = {};
  greet(connection);
  for (const Time now = start.now(); next_pose_ < now;) next_pose_ = next_pose_ + LightViewer::kPoseInterval;
  return {};
}

void RealViewer::take(Connection& connection, ByteSpan message, Time now) {
  LightViewer::Received received = light_.receive(message, now + clock_);
  const Duration interval = light_.request().keyframe_interval;
  tally_.add(received, message.size(), begin_ + clock_ + interval, end_ + clock_ - interval);
  if (received.resume) {
    move_.up += received.resume->size();
    connection.send(std::move(*received.resume));
  }
  if (!received.is_keyframe && !moving_) return;
  if (moving_) move_.down += message.size();
  if (!received.is_keyframe) return;
  if (const auto cause = std::exchange(moving_, std::nullopt); cause && last_keyframe_at_ && isMeasured(now)) {
    move_.cause = *cause;
    move_.is_resumed = received.is_resumed;
    move_.at_s = (now - begin_).toSeconds();
    move_.gap_ms = (now - *last_keyframe_at_).toMilliseconds();
    moves_.push_back(move_);
  }
  last_keyframe_at_ = now;
}

}  // namespace foreland::lab
