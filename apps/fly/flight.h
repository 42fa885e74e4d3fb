// One flight over a link, in real time.
#pragma once

#include <chrono>
#include <functional>

#include "apps/fly/link.h"
#include "base/result.h"
#include "client/fly/player.h"

namespace foreland::apps {

inline constexpr std::chrono::milliseconds kConnectTimeout{10'000};

// What is called during a flight; either may be empty.
struct FlightHooks {
  std::function<Status(const client::Player&)> on_welcome;  // once, when the server has said what scene it
                                                            // shows; an Error ends the flight
  std::function<void(const client::Player&)> on_frame;      // after each frame
};

// Flies until the path's end, a frame every `frame`. An Error if `on_welcome` or the session fails, or if the program
// is interrupted.
Status fly(Link& link, client::Player& player, std::chrono::nanoseconds frame, const FlightHooks& hooks);

}  // namespace foreland::apps
