// A player's connection to its server, over time: while it is lost, frames continue and new ones are tried. One thread.
#pragma once

#include <chrono>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include "base/result.h"
#include "base/time.h"
#include "client/fly/net/web_socket_client.h"
#include "client/fly/player.h"

namespace foreland::apps {

class Link {
 public:
  using Clock = client::WebSocketClient::Clock;

  // `seed` spreads the attempts of many viewers that have lost the same server.
  Link(client::WebSocketClient connection, std::string url, client::WebSocketClient::Options options, uint32_t seed)
      : connection_(std::move(connection)), url_(std::move(url)), options_(std::move(options)), random_(seed) {}

  // Sends and receives messages until `until`, and no shorter. When the connection is lost, it tries to make a new one,
  // with which the player resumes: at once if the server asks for that (client::LostBy::kMigrate), else within a fifth
  // of a second, and again and again, ever more rarely. An Error if that fails for 30 seconds.
  Status run(client::Player& player, Clock::time_point epoch, Clock::time_point until);
  void close();

 private:
  Status carry(client::Player& player, Clock::time_point epoch, Clock::time_point until);
  Status recover(client::Player& player, Clock::time_point epoch, Clock::time_point until);
  void connect(client::Player& player, Clock::time_point epoch);
  Clock::duration wait();

  std::optional<client::WebSocketClient> connection_;
  std::string url_;
  client::WebSocketClient::Options options_;
  std::minstd_rand random_;
  Error lost_{ErrorCode::kIo, {}};
  Clock::time_point lost_at_, next_attempt_;
  int attempts_ = 0;  // since the connection was lost
};

// Of a player's clock, which begins at `epoch`.
Time timeSince(Link::Clock::time_point epoch);

}  // namespace foreland::apps
