// Points in time and durations, as int64 microseconds. The name of a variable says on which clock. Nothing here reads a
// clock: time is a parameter everywhere but in mains, sockets and tools. Value types.
#pragma once

#include <compare>
#include <cstdint>

namespace foreland {

struct Duration {
  int64_t us = 0;
  static constexpr Duration seconds(double s) { return {static_cast<int64_t>(s * 1e6 + (s < 0 ? -0.5 : 0.5))}; }
  static constexpr Duration milliseconds(int64_t ms) { return {ms * 1000}; }
  constexpr double toSeconds() const { return static_cast<double>(us) * 1e-6; }
  constexpr double toMilliseconds() const { return static_cast<double>(us) * 1e-3; }
  auto operator<=>(const Duration&) const = default;
  constexpr Duration operator-() const { return {-us}; }
};

struct Time {
  int64_t us = 0;
  constexpr double toSeconds() const { return static_cast<double>(us) * 1e-6; }
  static constexpr Time seconds(double s) { return {Duration::seconds(s).us}; }
  auto operator<=>(const Time&) const = default;
};

constexpr Duration operator+(Duration a, Duration b) { return {a.us + b.us}; }
constexpr Duration operator-(Duration a, Duration b) { return {a.us - b.us}; }
constexpr Duration operator*(Duration a, int64_t n) { return {a.us * n}; }
constexpr Time operator+(Time t, Duration d) { return {t.us + d.us}; }
constexpr Time operator-(Time t, Duration d) { return {t.us - d.us}; }
constexpr Duration operator-(Time a, Time b) { return {a.us - b.us}; }

}  // namespace foreland
