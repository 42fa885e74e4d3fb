// The views of a flight's keyframes as a session refines them that has to guess where the viewer will be. Pure.
#pragma once

#include <vector>

#include "bench/sections/flight_views.h"
#include "proto/message/control.h"

namespace foreland::bench {

struct PoseReports {
  Duration interval = Duration::milliseconds(50);  // between two poses that the viewer sends
  Duration link = Duration::milliseconds(50);      // there and back
};

// Each keyframe is sent an interval and the link's time before its own, by what the viewer has reported by then; its
// region allows for how wrong recent predictions were. The first one is of the pose where the flight begins. With the
// predictor kKnownPath these are keyframeViews().
std::vector<proto::View> predictedViews(const proto::Path& path, const FlightOptions& options,
                                        proto::Predictor predictor, const PoseReports& reports = {});

}  // namespace foreland::bench
