// A flight as the wire sees it: keyframe after keyframe, the header and the cut delta. Recorded once, coded as often as
// one likes.
#pragma once

#include <vector>

#include "bench/sections/flight_views.h"
#include "proto/message.h"
#include "proto/section.h"
#include "server/section/hierarchy.h"

namespace foreland::bench {

struct RecordedKeyframe {
  proto::KeyframeHeader header;
  proto::CutDelta delta;  // sorted
};

// The sections along the views, each as the difference from the one before; the first from nothing.
std::vector<RecordedKeyframe> recordFlight(const server::Hierarchy& hierarchy, const std::vector<server::View>& views,
                                           Duration keyframe_interval);

}  // namespace foreland::bench
