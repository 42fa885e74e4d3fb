// Estimates of a camera's motion that remember all poses since it last jumped, and forget old ones gradually. Both
// continue from the newest pose itself, which has no noise but rounding, and filter the rates alone; so what is
// predicted starts where the camera is, as with the other predictors. A filter costs O(1) a pose. One owner.
#pragma once

#include <array>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "proto/space/pose.h"
#include "server/view/extrapolation.h"

namespace foreland::server {

// Metres and radians a second between two poses; `turn` is along the axis of the rotation.
struct MotionRates {
  glm::dvec3 velocity{0}, turn{0};

  static MotionRates between(const proto::TimedPose& before, const proto::TimedPose& after);
};

// The rotation that takes `seconds` at the rate `turn`.
glm::dquat rotationOf(const glm::dvec3& turn, double seconds);

// Double exponential smoothing (LaViola 2003, "Double exponential smoothing: an alternative to Kalman filter-based
// predictive tracking"). The slope that it gives is the sequence of differences, smoothed exponentially twice, and is
// computed so here, because poses need not be evenly spaced.
class DoubleExponential {
 public:
  static constexpr double kTimeConstant_s = 0.04;  // of each smoothing

  void add(const MotionRates& rates, double seconds);
  Extrapolation extrapolate() const;

 private:
  MotionRates once_, twice_;
  bool is_empty_ = true;
};

// A Kalman filter whose state is position, velocity and acceleration, driven by white noise in the jerk; the turn is a
// state of its own, driven by white noise in its change. Only the ratio of the variances matters for what it predicts;
// it was chosen on a paraglider's track and the tours (docs/LATENCY.md).
class KalmanMotion {
 public:
  static constexpr double kObserved_m2 = 1e-2;   // variance of an observed position
  static constexpr double kJerk = 1e2;           // spectral density of the jerk, m^2/s^5
  static constexpr double kTurnObserved = 1e-2;  // variance of an observed turn, (rad/s)^2
  static constexpr double kTurnChange = 1;       // spectral density of its change, (rad/s)^2/s

  explicit KalmanMotion(const proto::Pose& first) : position_(first.eye) {}
  void add(const proto::Pose& pose, const MotionRates& rates, double seconds);
  Extrapolation extrapolate() const;

 private:
  void predict(double seconds);
  void observe(const glm::dvec3& position);

  // The three axes have one covariance, because they have the same noise.
  glm::dvec3 position_, velocity_{0}, acceleration_{0}, turn_{0};
  std::array<std::array<double, 3>, 3> covariance_{{{kObserved_m2, 0, 0}, {0, 1e4, 0}, {0, 0, 1e2}}};
  double turn_variance_ = 1e2;
};

}  // namespace foreland::server
