// One flight over a link, in real time.
#pragma once

#include <chrono>
#include <functional>

#include "apps/fly/link.h"
#include "base/result.h"
#include "client/fly/player.h"

namespace foreland::apps {

inline constexpr std::chrono::milliseconds kConnectTimeout{10'000};

// Flies until the path's end, a frame every `frame`. `on_welcome` is called once, when the server has said what scene
// it shows; null for no such check. An Error if that, or the session, fails, or if the program is interrupted.
Status fly(Link& link, client::Player& player, std::chrono::nanoseconds frame,
           const std::function<Status(const client::Player&)>& on_welcome);

}  // namespace foreland::apps
