// What a change of view takes off the slack of tests (adapter.h): the motion that their outcomes may have seen.
// Plain values; any thread.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <limits>

namespace foreland::proto {

// For each guard (Metric::Guard) `fixed`, and `per_reach` times the distance from the eye.
struct Toll {
  static constexpr size_t kGuards = 4;
  std::array<float, kGuards> fixed{}, per_reach{};

  // Rounded up.
  void set(size_t guard, double fixed_m, double per_reach_m) {
    fixed[guard] = static_cast<float>(fixed_m * 1.00001 + 1e-6);
    per_reach[guard] = static_cast<float>(per_reach_m * 1.00001);
  }
  [[gnu::always_inline]] double of(size_t guard, double reach_m) const {
    return fixed[guard] + per_reach[guard] * reach_m;
  }
  // The same for all guards.
  static Toll even() { return {{1, 1, 1, 1}, {}}; }
  bool isEndless() const { return std::isinf(fixed[0]); }
  // What no slack survives.
  static Toll endless() {
    constexpr float kEndless = std::numeric_limits<float>::infinity();
    return {{kEndless, kEndless, kEndless, kEndless}, {}};
  }
};

// Angle between two orientations, rounded up.
inline double turnBetween(const glm::dquat& a, const glm::dquat& b) {
  const glm::dquat d = glm::conjugate(a) * b;
  return 2 * std::asin(std::min(1.0, std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z))) * (1 + 1e-12) + 1e-15;
}

}  // namespace foreland::proto
