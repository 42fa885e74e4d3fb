#include "lab/occlusion/predicted_views.h"

#include <algorithm>

#include "server/view/prediction_errors.h"

namespace foreland::lab {

namespace {

class Guesser {
 public:
  Guesser(const proto::Path& path, const FlightOptions& options, proto::Predictor predictor)
      : path_(path), options_(options), predictor_(predictor) {}

  void hear(Time reported) {
    history_.add({reported, path_.at(reported)});
    for (; judged_ < views_.size() && times_[judged_] <= reported; ++judged_)
      errors_.add(views_[judged_].pose, path_.at(times_[judged_]), options_.keyframe_interval);
  }

  void guess(Time t) {
    const Duration T = options_.keyframe_interval;
    const server::ExpectedMotion motion(history_, predictor_);
    proto::View view{motion.at(t), options_.lens, options_.tau_px};
    const server::Region region = server::regionOf(view.pose, motion, t - T, t + T), error = errors_.estimate(T);
    view.region_radius_m = region.radius_m + error.radius_m;
    view.region_angle_rad = region.angle_rad + error.angle_rad;
    views_.push_back(view);
    eye_paths_.push_back([history = history_, predictor = predictor_, t, T, error] {
      return server::eyePathOf(server::ExpectedMotion(history, predictor), t - T, t + T, T, error.radius_m);
    });
    times_.push_back(t);
  }

  PredictedFlight take() { return {std::move(views_), std::move(eye_paths_)}; }

 private:
  const proto::Path& path_;
  const FlightOptions& options_;
  proto::Predictor predictor_;
  server::PoseHistory history_;
  server::PredictionErrors errors_;
  std::vector<proto::View> views_;
  std::vector<PredictedFlight::EyePath> eye_paths_;
  std::vector<Time> times_;
  size_t judged_ = 0;
};

PredictedFlight knownFlight(const proto::Path& path, const FlightOptions& options) {
  PredictedFlight flight{keyframeViews(path, options, Guarantee::kEveryFrame), {}};
  const Duration T = options.keyframe_interval;
  for (size_t i = 0; i < flight.views.size(); ++i)
    flight.eye_paths.push_back([&path, T, t = Time{} + T * static_cast<int64_t>(i)] {
      return server::eyePathOf(server::ExpectedMotion(path), t - T, t + T, T, 0);
    });
  return flight;
}

}  // namespace

PredictedFlight predictedFlight(const proto::Path& path, const FlightOptions& options, proto::Predictor predictor,
                                const PoseReports& reports) {
  if (predictor == proto::Predictor::kKnownPath) return knownFlight(path, options);
  Guesser guesser(path, options, predictor);
  const Duration T = options.keyframe_interval;
  Time reported;
  guesser.hear(reported);
  for (Time t; t <= Time::seconds(options.seconds); t = t + T) {
    for (; reported + reports.interval <= t - T - reports.link; guesser.hear(reported))
      reported = reported + reports.interval;
    guesser.guess(t);
  }
  return guesser.take();
}

}  // namespace foreland::lab
