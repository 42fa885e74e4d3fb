#include "server/occlusion/horizon/horizon.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace foreland::server {

namespace {

// Sums of floats are off by less: coordinates by 2^-11 steps at most, on slopes of 200 m a step.
constexpr double kRounding_m = 0.1;

}  // namespace

void Horizon::look(const EyeCapsule& eyes, double bin) {
  eyes_ = eyes;
  bin_ = std::max(bin, HorizonSide::kMinBin);
  extent_m_ = glm::length(eyes.way) + 2 * eyes.radius_m;
  const glm::dvec3 eye = grid_.toAxes(eyes.eye), way = grid_.directionToAxes(eyes.way);
  begin_m_ = eye.z;
  eyes_in_grid_ = {grid_.toGrid(glm::dvec2(eye)), grid_.directionToGrid(glm::dvec2(way)),
                   eyes.radius_m * grid_.stepsOfMetre(), eye.z + std::max(0.0, way.z) + eyes.radius_m + kRounding_m};
  for (HorizonSide& side : sides_) side.forget();
}

// Which directions a square fills, and the slopes that hide it there.
struct Horizon::Wedge {
  double near;               // steps ahead
  double low = 0, high = 0;  // tangents

  Wedge(const Square& s, const HorizonSide& side, double eye_m) {
    const glm::dvec2 a = side.turned(s.low), b = side.turned(s.high), tilt = side.turned(s.tilt_m);
    near = std::min(a.x, b.x) - side.reference().x;
    const double far = std::max(a.x, b.x) - side.reference().x, left = a.y - side.reference().y,
                 right = b.y - side.reference().y;
    if (near <= 0) return;
    low = left / (left < 0 ? near : far);
    high = right / (right > 0 ? near : far);
    const double top = s.top_m - eye_m, height = s.height_m - eye_m;
    box_ = top / (top > 0 ? near : far);
    const std::array<double, 4> slope{(height - tilt.x - tilt.y) / near, (height + tilt.x - tilt.y) / far,
                                      (height - tilt.x + tilt.y) / near, (height + tilt.x + tilt.y) / far},
        tangent{left / near, left / far, right / near, right / far};
    per_ = (std::max(slope[2], slope[3]) - std::max(slope[0], slope[1])) / (high - low);
    at_low_ = slope[0] - per_ * (tangent[0] - low);
    for (size_t i = 1; i < 4; ++i) at_low_ = std::max(at_low_, slope[i] - per_ * (tangent[i] - low));
  }
  // In the directions between two tangents.
  double slope(double from, double to) const {
    return std::min(box_, at_low_ + per_ * ((per_ > 0 ? std::min(to, high) : std::max(from, low)) - low));
  }

 private:
  double box_ = 0;               // hides it everywhere
  double at_low_ = 0, per_ = 0;  // hides it at the lowest tangent; its increase with the tangent
};

HorizonSide& Horizon::sideTowards(const Square& square) {
  const glm::dvec2 way = 0.5 * (square.low + square.high - eyes_in_grid_.way) - eyes_in_grid_.begin;
  const bool is_x = std::fabs(way.x) > std::fabs(way.y);
  const uint32_t number = (is_x ? 0 : 1) + ((is_x ? way.x : way.y) > 0 ? 0 : 2);
  HorizonSide& side = sides_[number];
  if (!side.isMade()) side.look(grid_, eyes_in_grid_, number, bin_);
  return side;
}

bool Horizon::hides(const Square& square) {
  HorizonSide& side = sideTowards(square);
  const Wedge wedge(square, side, eyes_in_grid_.highest_m);
  if (wedge.near < HorizonSide::kNearest || wedge.low < -HorizonSide::kMaxTangent ||
      wedge.high >= HorizonSide::kMaxTangent)
    return false;
  if (grid_.isOverGlobe() && 2 * extent_m_ > wedge.near * grid_.metresOfStep()) return false;
  const uint32_t last = side.binOf(wedge.high);
  if (last >= side.binCount()) return false;
  for (uint32_t bin = side.binOf(wedge.low); bin <= last; ++bin) {
    const double slope = wedge.slope(side.tangentOf(bin), side.tangentOf(bin + 1)) * side.slopesOfStep();
    if (side.slope(bin, wedge.near) < std::max(slope, HorizonSide::kMinSlope)) return false;
  }
  return true;
}

uint64_t Horizon::segmentsBuilt() const {
  uint64_t built = 0;
  for (const HorizonSide& side : sides_) built += side.segmentsBuilt();
  return built;
}

size_t Horizon::bytes() const {
  size_t bytes = sizeof(*this);
  for (const HorizonSide& side : sides_) bytes += side.bytes();
  return bytes;
}

}  // namespace foreland::server
