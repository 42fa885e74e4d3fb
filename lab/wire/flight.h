// The keyframes of a flight as a server sends them, recorded so that several measurements can read the same bytes.
#pragma once

#include <vector>

#include "lab/sections/flight_views.h"
#include "server/section/sender.h"

namespace foreland::lab {

struct RecordedKeyframe {
  proto::View view;  // as the header states it
  Bytes message;
  size_t delta_bytes = 0;  // the message's last
  proto::DeltaBits bits;   // where they went
  proto::SurfaceBits object_bits;
  size_t nodes = 0;  // in the section that results
  size_t added = 0, removed = 0;
  size_t known = 0, memory_bytes = 0;  // nodes that are remembered beside the section, and what that takes the server
};

// The sections along the views, each as the difference from the one before; the first from nothing. The client
// remembers what fits into `memory_bytes`.
std::vector<RecordedKeyframe> recordFlight(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views,
                                           Duration keyframe_interval,
                                           uint32_t memory_bytes = proto::kDefaultMemoryBytes);

}  // namespace foreland::lab
