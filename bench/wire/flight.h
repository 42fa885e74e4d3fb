// The keyframes of a flight as a server sends them, recorded so that several measurements can read the same bytes.
#pragma once

#include <vector>

#include "bench/sections/flight_views.h"
#include "server/section/sender.h"

namespace foreland::bench {

struct RecordedKeyframe {
  proto::View view;  // as the header states it
  Bytes message;
  size_t delta_bytes = 0;  // the message's last
  proto::DeltaBits bits;   // where they went
  proto::SurfaceBits object_bits;
  size_t nodes = 0;  // in the section that results
  size_t added = 0, removed = 0;
};

// The sections along the views, each as the difference from the one before; the first from nothing.
std::vector<RecordedKeyframe> recordFlight(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views,
                                           Duration keyframe_interval);

}  // namespace foreland::bench
