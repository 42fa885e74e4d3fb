// Places on command lines: LAT,LON,HEIGHT, or x and y of a planar scene's map and the height; heights are metres above
// the ground. Header only; any thread.
#pragma once

#include <charconv>
#include <cmath>
#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <vector>

#include "proto/space/frame.h"

namespace foreland::apps {

// Finite numbers with commas between; nothing of any other text.
inline std::optional<std::vector<double>> numbersOf(const std::string& text) {
  std::vector<double> numbers;
  const char *at = text.data(), *end = at + text.size();
  while (true) {
    double number = 0;
    const auto [next, error] = std::from_chars(at, end, number);
    if (error != std::errc{} || !std::isfinite(number)) return std::nullopt;
    numbers.push_back(number);
    if (next == end) return numbers;
    if (*next != ',') return std::nullopt;
    at = next + 1;
  }
}

// At height 0; of latitude and longitude in degrees, or of the map's x and y.
inline proto::LatticePosition latticeOf(const proto::FrameTransform& transform, double a, double b) {
  constexpr double kDegree = 0.017453292519943295;
  if (transform.frame().isOnEllipsoid())
    return transform.toLattice(transform.toScene(proto::Geodetic{a * kDegree, b * kDegree, 0}));
  return transform.toLattice({glm::dvec2(a, b) - transform.frame().map_origin_m, 0});
}

}  // namespace foreland::apps
