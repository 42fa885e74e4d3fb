// The views of a flight's keyframes as a session refines them that has to guess where the viewer will be. Pure.
#pragma once

#include <functional>
#include <vector>

#include "lab/sections/flight_views.h"
#include "proto/message/control.h"
#include "server/occlusion/viewer_occlusion.h"

namespace foreland::lab {

struct PoseReports {
  Duration interval = Duration::milliseconds(50);  // between two poses that the viewer sends
  Duration link = Duration::milliseconds(50);      // there and back
};

struct PredictedFlight {
  // Where the server expects the eye when it computes a keyframe, and afterwards.
  using EyePath = std::function<server::PredictedEyePath()>;

  std::vector<proto::View> views;  // of the keyframes
  std::vector<EyePath> eye_paths;
};

// Each keyframe is sent an interval and the link's time before its own, by what the viewer has reported by then; its
// region allows for how wrong recent predictions were. The first one is of the pose where the flight begins. With the
// predictor kKnownPath the views are keyframeViews(). `path` must outlive the result.
PredictedFlight predictedFlight(const proto::Path& path, const FlightOptions& options, proto::Predictor predictor,
                                const PoseReports& reports = {});

// Tells a viewer's visibility before each keyframe what the flight's eye path is. Both must outlive it.
class Foresight final : public proto::BlockVisibility, public server::ObjectVisibility {
 public:
  Foresight(server::ViewerOcclusion& inner, const PredictedFlight& flight) : inner_(inner), flight_(flight) {}

  void begin(const proto::View& view) override {
    inner_.expect(flight_.eye_paths.at(keyframe_++)());
    inner_.begin(view);
  }
  bool isHidden(const proto::BlockId& block) override { return inner_.isHidden(block); }
  uint32_t changes(const proto::BlockId& lowest, uint32_t known, uint32_t hidden) override {
    return inner_.changes(lowest, known, hidden);
  }
  bool isObjectHidden(size_t object, size_t nodes) override { return inner_.isObjectHidden(object, nodes); }

 private:
  server::ViewerOcclusion& inner_;
  const PredictedFlight& flight_;
  size_t keyframe_ = 0;
};

}  // namespace foreland::lab
