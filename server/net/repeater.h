// Takes turns of something on the I/O thread, a while apart, until a turn says that it was the last. A turn that throws
// is one that fails, and no more; `on_failure` is told. If there is not even memory to wait for the next turn, that
// leaves the handler as an exception, and resume() goes on. Private to server/net; I/O thread.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <utility>

#include "base/guarded.h"
#include "base/time.h"

namespace foreland::server {

class Repeater {
 public:
  Repeater(boost::asio::io_context& io, std::function<void(const char* what)> on_failure)
      : timer_(io), on_failure_(std::move(on_failure)) {}

  // The first turn is in `every`. `turn` returns whether there is to be another one.
  void start(Duration every, std::function<bool()> turn) {
    every_ = every;
    turn_ = std::move(turn);
    resume();
  }
  void stop() {
    turn_ = nullptr;
    timer_.cancel();
  }

  // Waits for the next turn, if there is to be one and nobody waits for it.
  void resume() {
    if (is_waiting_ || !turn_) return;
    timer_.expires_after(std::chrono::microseconds(every_.us));
    timer_.async_wait([this](boost::system::error_code) {
      is_waiting_ = false;
      if (turn_ && takeTurn()) return resume();
      turn_ = nullptr;
    });
    is_waiting_ = true;
  }

 private:
  bool takeTurn() {
    bool goes_on = true;
    guarded([&] { goes_on = turn_(); }, on_failure_);
    return goes_on;
  }

  boost::asio::steady_timer timer_;
  const std::function<void(const char*)> on_failure_;
  Duration every_;
  std::function<bool()> turn_;
  bool is_waiting_ = false;
};

}  // namespace foreland::server
