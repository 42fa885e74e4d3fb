// Camera frames of Hoppe's programs (MeshTools, libHh/FrameIO): `F bin` and 13 numbers.
#include <array>
#include <charconv>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "base/lines.h"
#include "client/fly/tracks/track.h"
#include "client/fly/tracks/track_builder.h"
#include "proto/space/pose.h"

namespace foreland::client {

namespace {

constexpr double kFramesPerSecond = 30;
constexpr double kFarthest = 1e9;    // model units
constexpr double kMaxSkewed = 0.01;  // an axis' length may differ from 1 by so much, two axes from a right angle

// The numbers of a line after its first letter; nothing if they are not `count` finite ones.
template <size_t count>
std::optional<std::array<double, count>> numbersIn(std::string_view line) {
  std::array<double, count> out{};
  const char *at = line.data() + 1, *const end = line.data() + line.size();
  for (double& number : out) {
    while (at < end && (*at == ' ' || *at == '\t')) ++at;
    const auto [next, error] = std::from_chars(at, end, number);
    if (error != std::errc{} || !(std::fabs(number) <= kFarthest)) return std::nullopt;
    at = next;
  }
  while (at < end && (*at == ' ' || *at == '\t' || *at == '\r')) ++at;
  return at == end ? std::optional(out) : std::nullopt;
}

std::optional<CameraFrame> frameOf(std::string_view line) {
  const auto n = numbersIn<14>(line);
  if (!n) return std::nullopt;
  const auto vector = [&](size_t i) { return glm::dvec3((*n)[i], (*n)[i + 1], (*n)[i + 2]); };
  const glm::dvec3 forward = vector(1), left = vector(4), up = vector(7);
  for (const glm::dvec3& axis : {forward, left, up})
    if (std::fabs(glm::length(axis) - 1) > kMaxSkewed) return std::nullopt;
  for (const double skew : {glm::dot(forward, left), glm::dot(left, up), glm::dot(up, forward)})
    if (std::fabs(skew) > kMaxSkewed) return std::nullopt;
  if (glm::dot(glm::cross(forward, left), up) < 0) return std::nullopt;  // a mirror image
  return CameraFrame{0, vector(10), proto::lookAlong(glm::normalize(forward), glm::normalize(up))};
}

}  // namespace

Result<Track> parseCameraFrames(std::string_view text, const std::string& name) {
  TrackBuilder notes(name);
  Track track;
  Lines lines(text);
  for (std::string_view content; track.cameras.size() < Track::kMaxFixes && lines.next(content);) {
    if (!content.starts_with("F ")) continue;
    if (auto frame = frameOf(content)) {
      frame->time_s = static_cast<double>(track.cameras.size()) / kFramesPerSecond;
      track.cameras.push_back(*frame);
    } else {
      notes.skip(lines.number(),
                 "no camera frame: F, 0, three axes at right angles, a position and a zoom are expected");
    }
  }
  notes.note("no times recorded; 30 frames a second assumed");
  return std::move(notes).finish(std::move(track));
}

}  // namespace foreland::client
