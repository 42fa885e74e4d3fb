#include "client/fly/exaggeration.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/mat3x3.hpp>

namespace foreland::client {

namespace {

constexpr double kSpare = 1.02;            // for what is between the directions that are looked at
constexpr double kMostTangent = 8;         // of a lens of nearly half a turn
constexpr uint32_t kMostPixels = 16384;    // of a lens, a side (proto::isUsable)
constexpr int kPitches = 181, kSteps = 9;  // that are looked at
constexpr int kHalvings = 50;

glm::dvec3 tall(const glm::dvec3& v, double factor) { return {v.x, v.y, factor * v.z}; }

proto::Pose pitched(const proto::Pose& pose, double angle_rad) {
  return {pose.eye, pose.orientation * glm::angleAxis(angle_rad, glm::dvec3(1, 0, 0))};
}

// Along the columns: what is right, above and behind.
glm::dmat3 axesOf(const proto::Pose& pose) { return {pose.right(), pose.up(), -pose.forward()}; }

proto::Pose withoutRoll(const proto::Pose& pose) {
  return {pose.eye,
          proto::lookAlong(pose.forward(), std::fabs(pose.forward().z) < 0.9999 ? glm::dvec3(0, 0, 1) : pose.up())};
}

// Looks at the middle, from below to above, of what is drawn.
proto::Pose poseAskedFor(const proto::Pose& drawn, double factor, double tan_half) {
  const auto edge = [&](double side) {
    return glm::normalize(tall(drawn.orientation * glm::dvec3(0, side * tan_half, -1), 1 / factor));
  };
  const glm::dvec3 top = edge(1), bottom = edge(-1);
  return {drawn.eye, proto::lookAlong(glm::normalize(top + bottom), glm::normalize(top - bottom))};
}

// How much longer a small step about a place of the asked picture is in the drawn one, at most: the larger singular
// value of the map between them. `to_drawn` leads from the asked camera's axes to the drawn one's.
double growth(const glm::dmat3& to_drawn, const glm::dvec2& at) {
  const glm::dvec3 p = to_drawn * glm::dvec3(at, -1), along_x = to_drawn[0], along_y = to_drawn[1];
  const auto step = [&](const glm::dvec3& d) {
    return glm::dvec2(d.x * -p.z + p.x * d.z, d.y * -p.z + p.y * d.z) / (p.z * p.z);
  };
  const glm::dvec2 a = step(along_x), b = step(along_y);
  const double sum = glm::dot(a, a) + glm::dot(b, b), area = a.x * b.y - a.y * b.x;
  return std::sqrt((sum + std::sqrt(std::max(sum * sum - 4 * area * area, 0.0))) / 2);
}

struct WidestView {
  double tan_x, tan_y, finer = 1;

  // Of the camera at a pitch.
  void add(double pitch_rad, double factor, double tan_wide, double tan_tall) {
    const proto::Pose drawn = pitched({.eye = {}, .orientation = proto::lookAlong({0, 1, 0}, {0, 0, 1})}, pitch_rad);
    const glm::dmat3 drawn_axes = axesOf(drawn), asked_axes = axesOf(poseAskedFor(drawn, factor, tan_tall));
    const auto stretched = [](const glm::dmat3& axes, double by) {
      return glm::dmat3(tall(axes[0], by), tall(axes[1], by), tall(axes[2], by));
    };
    const glm::dmat3 to_asked = glm::transpose(asked_axes) * stretched(drawn_axes, 1 / factor),
                     to_drawn = glm::transpose(drawn_axes) * stretched(asked_axes, factor);
    for (int i = 0; i < kSteps; ++i)
      for (int j = 0; j < kSteps; ++j) {
        const glm::dvec2 side(2.0 * i / (kSteps - 1) - 1, 2.0 * j / (kSteps - 1) - 1);
        const glm::dvec3 seen = to_asked * glm::dvec3(side.x * tan_wide, side.y * tan_tall, -1);
        if (seen.z >= 0) {
          tan_x = tan_y = kMostTangent;
          continue;
        }
        const glm::dvec2 at(seen.x / -seen.z, seen.y / -seen.z);
        tan_x = std::max(tan_x, std::fabs(at.x)), tan_y = std::max(tan_y, std::fabs(at.y));
        finer = std::max(finer, growth(to_drawn, at));
      }
  }
};

}  // namespace

Exaggeration Exaggeration::of(double factor, const proto::Lens& drawn) {
  if (factor == 1) return {.factor = 1, .drawn = drawn, .asked = drawn, .finer = 1};
  const double tan_tall = drawn.tanHalfFov(), tan_wide = tan_tall * drawn.width_px / drawn.height_px;
  WidestView wanted{.tan_x = tan_wide, .tan_y = tan_tall};
  for (int i = 0; i < kPitches; ++i)
    wanted.add(glm::pi<double>() * (static_cast<double>(i) / (kPitches - 1) - 0.5), factor, tan_wide, tan_tall);
  const auto spare = [](double tan) { return std::min(kSpare * tan, kMostTangent); };
  const double tan_x = spare(wanted.tan_x), tan_y = spare(wanted.tan_y);
  const double side_px = 2 * drawn.focalPx() * std::max(tan_x, tan_y);
  const double focal_px = drawn.focalPx() * std::min(1.0, kMostPixels / side_px);
  const auto pixels = [&](double tan) {
    return std::min(kMostPixels, static_cast<uint32_t>(std::ceil(2 * focal_px * tan)));
  };
  const proto::Lens lens{
      .vertical_fov_rad = 2 * std::atan(tan_y), .width_px = pixels(tan_x), .height_px = pixels(tan_y)};
  return {.factor = factor,
          .drawn = drawn,
          .asked = lens,
          .finer = kSpare * wanted.finer * drawn.focalPx() / lens.focalPx()};
}

proto::Pose Exaggeration::askedPose(const proto::Pose& drawn_pose) const {
  return factor == 1 ? drawn_pose : poseAskedFor(withoutRoll(drawn_pose), factor, drawn.tanHalfFov());
}

proto::Pose Exaggeration::drawnPose(const proto::Pose& asked_pose) const {
  if (factor == 1) return asked_pose;
  double low = -glm::half_pi<double>(), high = glm::half_pi<double>();
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (low + high) / 2;
    const glm::dvec3 ahead = poseAskedFor(pitched(asked_pose, middle), factor, drawn.tanHalfFov()).forward();
    (glm::dot(ahead, asked_pose.up()) < 0 ? low : high) = middle;
  }
  return pitched(asked_pose, (low + high) / 2);
}

}  // namespace foreland::client
