// One viewer of a load in real time, flying as LoadSimulation flies it; of several servers it goes on to another one
// when its own hands it over or fails, and resumes there with what it holds. Private to lab/load. Reads the clock;
// each viewer has a thread of its own, whoever runs the load reads its results when that has ended.
#pragma once

#include <chrono>
#include <latch>
#include <optional>
#include <string>
#include <vector>

#include "base/rng.h"
#include "client/fly/net/web_socket_client.h"
#include "lab/load/cluster.h"
#include "lab/load/load_cast.h"
#include "lab/load/viewer_tally.h"

namespace foreland::lab {

// All viewers are connected before time begins, which is then the same for all.
struct RealStart {
  using Clock = client::WebSocketClient::Clock;
  explicit RealStart(size_t viewers) : connected(static_cast<std::ptrdiff_t>(viewers)) {}
  std::latch connected, go{1};
  Clock::time_point zero;

  Clock::time_point at(Time t) const { return zero + std::chrono::microseconds(t.us); }
  Time now() const { return {std::chrono::duration_cast<std::chrono::microseconds>(Clock::now() - zero).count()}; }
};

class RealViewer {
 public:
  // `begin` and `end` of the measured time, the server's clock; `urls`: of the servers, in the order in which they are
  // gone to, around and around.
  RealViewer(const LoadViewer& viewer, Time begin, Time end, std::vector<std::string> urls);

  void fly(RealStart& start);
  // An Error if there is only one server and the viewer lost it, or if no server takes it.
  const Status& status() const { return status_; }
  const ViewerTally& tally() const { return tally_; }
  const std::vector<ViewerMove>& moves() const { return moves_; }

 private:
  using Connection = client::WebSocketClient;
  Result<Connection> connect();
  Status fly(Connection& connection, const RealStart& start);
  Status stay(Connection& connection, const RealStart& start);
  Status moveOn(Connection& connection, const RealStart& start);
  void greet(Connection& connection);
  void take(Connection& connection, ByteSpan message, Time now);
  bool isMeasured(Time now) const { return now >= begin_ && now < end_; }

  LightViewer light_;
  Time comes_;
  Duration clock_;  // the viewer's less the server's
  Duration round_trip_;
  Time begin_, end_;
  std::vector<std::string> urls_;
  size_t server_ = 0;
  Rng chance_;
  Time next_pose_;
  std::optional<Time> last_keyframe_at_;
  std::optional<MoveCause> moving_;  // until the first keyframe from another server
  ViewerMove move_;
  std::vector<ViewerMove> moves_;
  ViewerTally tally_;
  Status status_;
};

}  // namespace foreland::lab
