// How long a recorded flight takes each end, in processor time of one thread: the median of five passes over the whole
// flight, each by a sender, an adapter or a client of its own that does nothing else meanwhile.
#pragma once

#include <vector>

#include "lab/wire/flight.h"

namespace foreland::lab {

struct FlightSeconds {
  double first_s = 0, rest_s = 0;  // the first keyframe, and all others
};

struct WireTimes {
  FlightSeconds adapt;   // the server's adaptation alone
  FlightSeconds send;    // adaptation and coding
  FlightSeconds decode;  // what a client does to take a keyframe, its own adaptation included, meshes not
};

WireTimes timeWire(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views,
                   const std::vector<RecordedKeyframe>& flight, Duration keyframe_interval);

}  // namespace foreland::lab
