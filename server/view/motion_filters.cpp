#include "server/view/motion_filters.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "base/smoothing.h"

namespace foreland::server {

namespace {

constexpr double kSpan_s = 0.1;  // over which an Extrapolation states its rotation

Extrapolation withTurn(const glm::dvec3& turn) {
  Extrapolation result;
  result.span_s = kSpan_s;
  result.rotation = rotationOf(turn, kSpan_s);
  return result;
}

void approach(glm::dvec3& value, const glm::dvec3& target, double share) { value += share * (target - value); }

}  // namespace

glm::dquat rotationOf(const glm::dvec3& turn, double seconds) {
  const double rate = glm::length(turn), half = 0.5 * rate * seconds;
  if (rate < 1e-12) return {1, 0, 0, 0};
  return {std::cos(half), turn * (std::sin(half) / rate)};
}

MotionRates MotionRates::between(const proto::TimedPose& before, const proto::TimedPose& after) {
  const double seconds = (after.time - before.time).toSeconds();
  MotionRates rates{(after.pose.eye - before.pose.eye) / seconds, glm::dvec3(0)};
  glm::dquat q = after.pose.orientation * glm::conjugate(before.pose.orientation);
  if (q.w < 0) q = -q;
  const glm::dvec3 axis(q.x, q.y, q.z);
  const double sine = glm::length(axis);
  if (sine > 1e-12) rates.turn = axis * (2 * std::atan2(sine, q.w) / (sine * seconds));
  return rates;
}

void DoubleExponential::add(const MotionRates& rates, double seconds) {
  if (is_empty_) once_ = twice_ = rates;
  is_empty_ = false;
  const double share = weightOfNew(seconds, kTimeConstant_s);
  approach(once_.velocity, rates.velocity, share);
  approach(once_.turn, rates.turn, share);
  approach(twice_.velocity, once_.velocity, share);
  approach(twice_.turn, once_.turn, share);
}

// `velocity` of an Extrapolation is that of half a span ago; with no acceleration that makes no difference.
Extrapolation DoubleExponential::extrapolate() const {
  Extrapolation result = withTurn(twice_.turn);
  result.velocity = twice_.velocity;
  return result;
}

void KalmanMotion::add(const proto::Pose& pose, const MotionRates& rates, double seconds) {
  predict(seconds);
  observe(pose.eye);
  turn_variance_ += kTurnChange * seconds;
  const double gain = turn_variance_ / (turn_variance_ + kTurnObserved);
  approach(turn_, rates.turn, gain);
  turn_variance_ *= 1 - gain;
}

// F P F' + Q of the Wiener-process acceleration model (Bar-Shalom, Li and Kirubarajan, "Estimation with applications to
// tracking and navigation", 6.2.3).
void KalmanMotion::predict(double h) {
  position_ += h * velocity_ + 0.5 * h * h * acceleration_;
  velocity_ += h * acceleration_;
  const double f[3][3] = {{1, h, h * h / 2}, {0, 1, h}, {0, 0, 1}};
  const double h2 = h * h, h3 = h2 * h, h4 = h3 * h, h5 = h4 * h;
  const double noise[3][3] = {{h5 / 20, h4 / 8, h3 / 6}, {h4 / 8, h3 / 3, h2 / 2}, {h3 / 6, h2 / 2, h}};
  const auto before = covariance_;
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j) {
      double sum = kJerk * noise[i][j];
      for (size_t k = 0; k < 3; ++k)
        for (size_t l = 0; l < 3; ++l) sum += f[i][k] * before[k][l] * f[j][l];
      covariance_[i][j] = sum;
    }
}

void KalmanMotion::observe(const glm::dvec3& position) {
  const glm::dvec3 off = position - position_;
  const auto before = covariance_;
  const double variance = before[0][0] + kObserved_m2;
  position_ += before[0][0] / variance * off;
  velocity_ += before[1][0] / variance * off;
  acceleration_ += before[2][0] / variance * off;
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j) covariance_[i][j] = before[i][j] - before[i][0] * before[0][j] / variance;
}

Extrapolation KalmanMotion::extrapolate() const {
  Extrapolation result = withTurn(turn_);
  result.acceleration = acceleration_;
  result.velocity = velocity_ - 0.5 * result.span_s * acceleration_;  // that of half a span ago
  return result;
}

}  // namespace foreland::server
