#include "apps/fly/flight.h"

#include <algorithm>

#include "apps/stop_signal.h"

namespace foreland::apps {

Status fly(Link& link, client::Player& player, std::chrono::nanoseconds frame, const FlightHooks& hooks) {
  const Link::Clock::time_point epoch = Link::Clock::now();
  Link::Clock::time_point next = epoch;
  bool is_welcomed = false;
  while (player.phase() != client::Player::Phase::kDone) {
    if (isStopRequested()) return Error{ErrorCode::kIo, "interrupted"};
    if (Status s = player.frame(timeSince(epoch)); !s.ok()) return s;
    if (hooks.on_frame) hooks.on_frame(player);
    next = std::max(next + frame, Link::Clock::now() - frame);  // after a stall there is no burst of frames
    if (Status s = link.run(player, epoch, next); !s.ok()) return s;
    if (is_welcomed || !player.viewer().welcome()) continue;
    is_welcomed = true;
    if (!hooks.on_welcome) continue;
    if (Status s = hooks.on_welcome(player); !s.ok()) return s;
  }
  return {};
}

}  // namespace foreland::apps
