// The work of one viewer's keyframes on the server, to be counted by an instruction counter, which says what it costs
// however busy the machine is: a real session, a viewer that holds nothing, a link of fixed latency, in virtual time.
// The same bytes for the same arguments. One thread.
#pragma once

#include <cstdint>
#include <memory>

#include "proto/message/message.h"
#include "proto/space/path.h"
#include "server/session/world.h"

namespace foreland::lab {

struct ServerFlightOptions {
  proto::ViewRequest request;
  int legs = 4;         // parts of the path that are flown, each by a session of its own, evenly apart
  double leg_s = 4;     // what is counted of each
  double run_in_s = 1;  // before it
  double round_trip_s = 0.05;
  // Sessions take turns, keyframe by keyframe, so that none finds its memory in a processor's caches; not one leg after
  // the other. Messages are the same.
  bool side_by_side = false;
};

// Of the keyframes that are counted.
struct ServerFlight {
  uint64_t keyframes = 0, nodes = 0, tested = 0, changed = 0, measured = 0, bytes = 0;
  uint64_t hash = 0;                    // of every message, those of the run-in included
  double region_m = 0, region_rad = 0;  // of the keyframes' regions, summed

  template <class Visit>
  void fields(const Visit& visit) const {
    visit("keyframes", keyframes);
    visit("nodes", nodes);
    visit("tested", tested);
    visit("changed", changed);
    visit("measured", measured);
    visit("bytes", bytes);
    visit("region_m", region_m);
    visit("region_rad", region_rad);
    visit("hash", hash);
  }
};

ServerFlight flyForServer(const std::shared_ptr<const server::World>& world, std::shared_ptr<const proto::Path> path,
                          const ServerFlightOptions& options);

}  // namespace foreland::lab
