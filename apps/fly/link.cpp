#include "apps/fly/link.h"

#include <algorithm>
#include <thread>
#include <utility>

namespace foreland::apps {
namespace {

constexpr std::chrono::seconds kTimeout{30};
constexpr std::chrono::milliseconds kReconnectTimeout{1000}, kFirstWait{200}, kLongestWait{2000};

}  // namespace

Time timeSince(Link::Clock::time_point epoch) {
  return {std::chrono::duration_cast<std::chrono::microseconds>(Link::Clock::now() - epoch).count()};
}

Status Link::run(client::Player& player, Clock::time_point epoch, Clock::time_point until) {
  do {
    const Status status = connection_ ? carry(player, epoch, until) : recover(player, epoch, until);
    if (!status.ok()) return status;
  } while (Clock::now() < until);
  return {};
}

// Until `until`, or until the connection is lost.
Status Link::carry(client::Player& player, Clock::time_point epoch, Clock::time_point until) {
  for (Bytes message; player.takeOutgoing(message);) connection_->send(std::move(message));
  const Status status =
      connection_->run(until, [&](ByteSpan message) { return player.receive(message, timeSince(epoch)); });
  if (status.ok() || status.error().code != ErrorCode::kIo) return status;
  lost_ = status.error();
  lost_at_ = Clock::now();
  attempts_ = 0;
  next_attempt_ = connection_->lostBy() == client::LostBy::kMigrate ? lost_at_ : lost_at_ + wait();
  connection_.reset();
  return {};
}

// Until the next attempt to connect, and with it, or until `until`.
Status Link::recover(client::Player& player, Clock::time_point epoch, Clock::time_point until) {
  if (Clock::now() - lost_at_ > kTimeout) return lost_;
  if (Clock::now() >= next_attempt_)
    connect(player, epoch);
  else
    std::this_thread::sleep_until(std::min(until, next_attempt_));
  return {};
}

void Link::connect(client::Player& player, Clock::time_point epoch) {
  options_.area = player.viewer().area();
  auto connection = client::WebSocketClient::connect(url_, kReconnectTimeout, options_);
  if (!connection.ok()) {
    ++attempts_;
    next_attempt_ = Clock::now() + wait();
    return;
  }
  player.reconnect(timeSince(epoch));
  connection_ = std::move(connection).value();
}

// At random, up to twice as long after each attempt that failed.
Link::Clock::duration Link::wait() {
  const auto longest = std::min<Clock::duration>(kFirstWait * (1 << std::min(attempts_, 8)), kLongestWait);
  return Clock::duration(std::uniform_int_distribution<Clock::rep>(0, longest.count())(random_));
}

void Link::close() {
  if (connection_) connection_->close();
}

}  // namespace foreland::apps
