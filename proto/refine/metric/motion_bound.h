// How far a change of view may have moved the camera, for each kind of motion that a test result can be sensitive to
// (motion_margin.h). Each adaptation step subtracts it from the slack of every test result (adapter.h). Plain
// values; any thread.
#pragma once

#include <array>
#include <limits>

#include <cmath>

namespace foreland::proto {

// For each sensitivity, `fixed` metres plus `per_distance` times the distance from the eye to the node.
struct MotionBound {
  static constexpr size_t kSensitivities = 4;
  std::array<float, kSensitivities> fixed{}, per_distance{};

  // Rounded up.
  void set(size_t sensitivity, double fixed_m, double per_metre) {
    fixed[sensitivity] = static_cast<float>(fixed_m * 1.00001 + 1e-6);
    per_distance[sensitivity] = static_cast<float>(per_metre * 1.00001);
  }
  [[gnu::always_inline]] double of(size_t sensitivity, double distance_m) const {
    return fixed[sensitivity] + per_distance[sensitivity] * distance_m;
  }
  // One metre for every sensitivity.
  static MotionBound even() { return {{1, 1, 1, 1}, {}}; }
  bool isUnbounded() const { return std::isinf(fixed[0]); }
  // No slack survives it.
  static MotionBound unbounded() {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    return {{kInfinity, kInfinity, kInfinity, kInfinity}, {}};
  }
};

}  // namespace foreland::proto
