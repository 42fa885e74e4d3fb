// Which flights `foreland bench latency` makes: every combination of what is asked for, or the default choice of them.
// Value types; pure; any thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "proto/message/control.h"
#include "proto/message/keyframe_interval.h"

namespace foreland::lab {

// One flight: how it is shown, over which link, and what is asked of the server.
struct LatencyCell {
  proto::Strategy strategy = proto::Strategy::kPredict;
  proto::Predictor predictor = proto::Predictor::kConstantVelocity;  // of `predict`; others have none
  std::string link = "fixed";                                        // link_models.h, or `trace`
  double round_trip_ms = 0;                                          // of `fixed` alone
  proto::KeyframeInterval keyframes = {};
  double tau_px = 1;
  std::string predictor_command = {}, link_command = {};  // programs in their places; empty: none

  bool operator==(const LatencyCell&) const = default;
  // For people and plots: `predict kalman`, `delay`.
  std::string how() const;
  std::string predictorText() const;
  std::string linkText() const { return link_command.empty() ? link : link_command; }

  template <class Visit>
  void fields(const Visit& visit) const {
    visit("strategy", std::string(proto::name(strategy)));
    visit("predictor", predictorText());
    visit("link", linkText());
    visit("round_trip_ms", round_trip_ms);
    visit("keyframe_ms", keyframes.shortest.toMilliseconds());
    visit("longest_keyframe_ms", keyframes.longest.toMilliseconds());  // 0: fixed
    visit("tau_px", tau_px);
  }
};

enum class GridSize : uint8_t { kDefault, kFull };

// What the user asks for; whatever is empty takes the grid's own values.
struct GridRequest {
  std::vector<std::string> strategies = {}, predictors = {}, links = {};
  std::vector<double> round_trips_ms = {}, taus_px = {};
  std::vector<std::string> keyframes_ms = {};  // as keyframe_interval.h reads them
  GridSize size = GridSize::kDefault;
  std::string predictor_command = {}, link_command = {};  // one more of the predictors, and of the links
};

// The cells, each once, in a fixed order. The default grid varies the round trip with all strategies and predictors at
// one interval and tolerance, and the interval and the tolerance with three of them at one round trip; the full one has
// all combinations. Values that are asked for take the place of the grid's own, in all combinations. Errors name what
// is unknown or out of range.
Result<std::vector<LatencyCell>> cellsOf(const GridRequest& request);

}  // namespace foreland::lab
