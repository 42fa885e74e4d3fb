#include "client/fly/track_path.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>

#include "proto/space/direction.h"

namespace foreland::client {

namespace {

constexpr double kTwoPi = 6.283185307179586;
constexpr double kSmooth_s = 1.0;  // of the track, either side: evens out the fixes' rounding to metres
constexpr double kLookBehind_s = 1, kLookAhead_s = 2;  // of the flight: the chord that the camera looks along
constexpr double kEnvelope_s = 1;                      // of the flight, either side
constexpr double kDownward_rad = 0.17;                 // about 10 degrees
constexpr double kStill_m = 1;                         // shorter chords give no direction

Error invalidArgument(std::string message) { return {ErrorCode::kInvalidArgument, std::move(message)}; }

// Mean over up to 2 * half + 1 neighbours, fewer and symmetric near the ends, so the ends stay where they are.
template <class T>
std::vector<T> boxSmooth(const std::vector<T>& in, size_t half) {
  if (half == 0 || in.size() < 3) return in;
  std::vector<T> sum(in.size() + 1, T(0)), out(in.size());
  // Relative to the first value: sums of thousands of large coordinates would lose digits.
  for (size_t i = 0; i < in.size(); ++i) sum[i + 1] = sum[i] + (in[i] - in[0]);
  for (size_t i = 0; i < in.size(); ++i) {
    const size_t h = std::min({half, i, in.size() - 1 - i});
    out[i] = in[0] + (sum[i + h + 1] - sum[i - h]) / static_cast<double>(2 * h + 1);
  }
  return out;
}

// A smooth profile nowhere below `in`: the largest value within `half`, then the mean of those within `half`.
std::vector<double> upperEnvelope(const std::vector<double>& in, size_t half) {
  std::vector<double> largest(in.size());
  for (size_t i = 0; i < in.size(); ++i)
    largest[i] = *std::max_element(in.begin() + static_cast<ptrdiff_t>(i - std::min(i, half)),
                                   in.begin() + static_cast<ptrdiff_t>(std::min(i + half + 1, in.size())));
  return boxSmooth(largest, half);
}

size_t stepsIn(double seconds, Duration step) { return static_cast<size_t>(std::lround(seconds / step.toSeconds())); }

Status checkTrack(const Track& track, const proto::FrameTransform& frame, const TrackOptions& o) {
  if (!(o.speed > 0) || o.speed > 10'000) return invalidArgument("--speed must be above 0 and at most 10000");
  if (!(o.from_s >= 0)) return invalidArgument("--from must not be negative");
  if (o.seconds && !(*o.seconds > 0)) return invalidArgument("--seconds must be positive");
  if (!(o.clearance_m >= 0) || o.clearance_m > 1e5) return invalidArgument("--clearance must be 0 to 100000 m");
  if (o.agl_m && (!(*o.agl_m >= 0) || *o.agl_m > 1e6)) return invalidArgument("--agl must be 0 to 1000000 m");
  if (o.from_s >= track.seconds())
    return invalidArgument("--from " + std::to_string(o.from_s) + " is after the track's end; it lasts " +
                           std::to_string(track.seconds()) + " s");
  const bool is_globe = frame.frame().kind == proto::FrameKind::kGlobe;
  if (!track.cameras.empty() && is_globe)
    return Error{ErrorCode::kUnsupported,
                 "a camera over another model is laid on a plane, and this scene is a globe: fly a recorded track of "
                 "latitudes and longitudes, or a tour"};
  if (!track.cameras.empty()) return {};
  if (!frame.frame().isOnEllipsoid())
    return Error{
        ErrorCode::kUnsupported,
        "the scene is in projected metres and a track is in latitude and longitude: build the scene from geographic "
        "elevation data (gdalwarp -t_srs EPSG:4326 -dstnodata -9999 makes it so), or fly a tour (--tour)"};
  if (track.heights == TrackHeights::kMissing && !o.agl_m)
    return invalidArgument("the track has no heights: give a height above ground with --agl");
  return {};
}

// Lattice position (x, y) and recorded height of a fix; longitudes are moved by whole turns into the scene's range.
glm::dvec3 latticeOf(const Fix& fix, const proto::Frame& frame) {
  const double east = fix.longitude_rad - frame.longitude0_rad;
  const double turned = east - kTwoPi * std::floor(east / kTwoPi);
  return {turned / frame.longitude_step_rad, (fix.latitude_rad - frame.latitude0_rad) / frame.latitude_step_rad,
          fix.height_m};
}

// Even steps through what was recorded.
struct Steps {
  double from_s, step_s;
  size_t count;
};

// For each step the two `points` around its time, and how far it is from the first to the second.
template <class Point, class Visit>
void forEachStep(const std::vector<Point>& points, const Steps& steps, const Visit& visit) {
  size_t next = 1;
  for (size_t i = 0; i < steps.count; ++i) {
    const double time_s = std::min(steps.from_s + static_cast<double>(i) * steps.step_s, points.back().time_s);
    while (next + 1 < points.size() && points[next].time_s < time_s) ++next;
    const Point &a = points[next - 1], &b = points[next];
    visit(a, b, (time_s - a.time_s) / (b.time_s - a.time_s));
  }
}

std::vector<glm::dvec3> resample(const Track& track, const proto::Frame& frame, const Steps& steps) {
  std::vector<glm::dvec3> out;
  out.reserve(steps.count);
  forEachStep(track.fixes, steps, [&](const Fix& a, const Fix& b, double share) {
    const glm::dvec3 pa = latticeOf(a, frame), pb = latticeOf(b, frame);
    out.push_back(pa + (pb - pa) * share);
  });
  return out;
}

glm::dvec3 normalAt(const Fix& fix) {
  return {std::cos(fix.latitude_rad) * std::cos(fix.longitude_rad),
          std::cos(fix.latitude_rad) * std::sin(fix.longitude_rad), std::sin(fix.latitude_rad)};
}

// Lays a track on a globe: by normals, which know no seam, and heights apart. All of it is inside the data.
void planOverGlobe(const Track& track, const proto::FrameTransform& frame, const Steps& steps, PlannedTrack& plan) {
  std::vector<glm::dvec3> normals;
  forEachStep(track.fixes, steps, [&](const Fix& a, const Fix& b, double share) {
    normals.push_back(proto::directionBetween(normalAt(a), normalAt(b), share));
    plan.heights_m.push_back(std::lerp(a.height_m, b.height_m, share));
  });
  const auto half = static_cast<size_t>(std::lround(kSmooth_s / steps.step_s));
  plan.heights_m = boxSmooth(plan.heights_m, half);
  for (const glm::dvec3& normal : boxSmooth(normals, half)) {
    const proto::LatticePosition at = frame.toLattice(frame.spheroid().position(normal, 0));
    plan.positions.emplace_back(at.x, at.y);
  }
}

// Where on the ground a lattice position is, metres east and north, near the middle of the scene.
struct Level {
  glm::dvec2 middle;        // lattice
  glm::dvec2 east_north_m;  // that a lattice step has, along x and along y
};

Level levelOf(const proto::FrameTransform& frame, const proto::GridShape& shape) {
  const glm::dvec2 middle{0.5 * (shape.samples_x - 1), 0.5 * (shape.samples_y - 1)};
  const auto at = [&](double x, double y) {
    return frame.toScene(proto::LatticePosition{middle.x + x, middle.y + y, 0});
  };
  return {middle, {glm::distance(at(0.5, 0), at(-0.5, 0)), glm::distance(at(0, 0.5), at(0, -0.5))}};
}

// Lays a camera's path on the scene.
PlannedTrack planCamera(const Track& track, const proto::FrameTransform& frame, const proto::GridShape& shape,
                        const Steps& steps) {
  constexpr double kFilled = 0.9;
  glm::dvec3 low = track.cameras.front().eye, high = low;
  for (const CameraFrame& c : track.cameras) low = glm::min(low, c.eye), high = glm::max(high, c.eye);
  const Level level = levelOf(frame, shape);
  const glm::dvec2 room_m = kFilled * level.east_north_m * glm::dvec2(shape.samples_x - 1, shape.samples_y - 1);
  const glm::dvec2 extent = glm::max(glm::dvec2(high - low), 1e-9);
  const double scale = std::min(room_m.x / extent.x, room_m.y / extent.y);
  const glm::dvec2 centre = 0.5 * glm::dvec2(low + high);
  PlannedTrack plan;
  forEachStep(track.cameras, steps, [&](const CameraFrame& a, const CameraFrame& b, double share) {
    const glm::dvec3 eye = a.eye + (b.eye - a.eye) * share;
    plan.positions.push_back(level.middle + scale * (glm::dvec2(eye) - centre) / level.east_north_m);
    plan.heights_m.push_back(scale * eye.z);
    plan.orientations.push_back(glm::slerp(a.orientation, b.orientation, share));
  });
  char note[160];
  std::snprintf(note, sizeof note, "a camera over another model, laid on the scene: one of its units is %.1f km",
                scale / 1000);
  plan.notes.emplace_back(note);
  return plan;
}

struct PathSpan {
  size_t first = 0, count = 0;
};

template <class Inside>
PathSpan longestSpan(size_t size, Inside&& inside) {
  PathSpan best;
  for (size_t i = 0; i < size;) {
    size_t end = i;
    while (end < size && inside(end)) ++end;
    if (end - i > best.count) best = {i, end - i};
    i = end + 1;
  }
  return best;
}

// Horizontal direction of flight at each position; where the camera stands still it keeps the direction before.
std::vector<glm::dvec3> directions(const std::vector<glm::dvec3>& eyes, const proto::FrameTransform& frame,
                                   Duration step) {
  const size_t behind = stepsIn(kLookBehind_s, step), ahead = stepsIn(kLookAhead_s, step), last = eyes.size() - 1;
  std::vector<glm::dvec3> out(eyes.size(), glm::dvec3(0));
  glm::dvec3 current{0};
  size_t first_known = eyes.size();
  for (size_t i = 0; i < eyes.size(); ++i) {
    const glm::dvec3 chord = eyes[std::min(i + ahead, last)] - eyes[i - std::min(i, behind)], up = frame.upAt(eyes[i]);
    const glm::dvec3 level = chord - up * glm::dot(chord, up);
    if (glm::length(level) > kStill_m) {
      current = glm::normalize(level);
      first_known = std::min(first_known, i);
    }
    out[i] = current;
  }
  const glm::dvec3 at_start = first_known < eyes.size() ? out[first_known] : glm::dvec3(0, 1, 0);
  std::fill_n(out.begin(), first_known, at_start);
  return boxSmooth(out, behind);
}

proto::Pose poseAt(const glm::dvec3& eye, const glm::dvec3& direction, const glm::dvec3& up) {
  const glm::dvec3 level = direction - up * glm::dot(direction, up);
  const glm::dvec3 ahead = glm::length(level) > 1e-6 ? glm::normalize(level) : glm::dvec3(0, 1, 0);
  return {eye, proto::lookAlong(std::cos(kDownward_rad) * ahead - std::sin(kDownward_rad) * up, up)};
}

// The pose of a camera that was recorded in axes of east, north and up. East is where the lattice's x axis goes.
proto::Pose poseOf(const glm::dvec3& eye, const glm::dquat& recorded, const glm::dvec2& position, double height_m,
                   const proto::FrameTransform& frame) {
  const glm::dvec3 up = frame.upAt(eye);
  const glm::dvec3 along = frame.toScene(proto::LatticePosition{position.x + 1, position.y, height_m}) - eye;
  const glm::dvec3 east = glm::normalize(along - up * glm::dot(along, up)), north = glm::cross(up, east);
  const auto toScene = [&](const glm::dvec3& v) { return east * v.x + north * v.y + up * v.z; };
  return {eye, proto::lookAlong(toScene(recorded * glm::dvec3(0, 0, -1)), toScene(recorded * glm::dvec3(0, 1, 0)))};
}

// The heights to fly at, and how many of the recorded ones were too low.
std::vector<double> heightProfile(const PlannedTrack& plan, std::span<const float> ground_m, const TrackOptions& o,
                                  size_t& lifted) {
  const bool is_camera = !plan.orientations.empty(), is_above_sea = !is_camera && !plan.undulations_m.empty();
  const auto recordedAt = [&](size_t i) {
    return plan.heights_m[i] + (is_above_sea ? double{plan.undulations_m[i]} : 0.0);
  };
  const size_t half = stepsIn(kEnvelope_s, plan.step);
  std::vector<double> ground(ground_m.begin(), ground_m.end());
  if (o.agl_m) {
    std::vector<double> out = upperEnvelope(ground, half);
    for (double& height : out) height += *o.agl_m;
    return out;
  }
  const double zero_m = is_camera ? std::reduce(ground.begin(), ground.end()) / static_cast<double>(ground.size()) : 0;
  std::vector<double> lift(ground.size());
  for (size_t i = 0; i < ground.size(); ++i) {
    lift[i] = std::max(0.0, ground[i] + o.clearance_m - recordedAt(i) - zero_m);
    lifted += lift[i] > 0;
  }
  std::vector<double> out = upperEnvelope(lift, half);
  for (size_t i = 0; i < out.size(); ++i) out[i] = std::max(out[i], lift[i]) + recordedAt(i) + zero_m;
  return out;
}

}  // namespace

Result<PlannedTrack> planTrack(const Track& track, const proto::FrameTransform& frame, const proto::GridShape& shape,
                               const TrackOptions& o) {
  if (Status s = checkTrack(track, frame, o); !s.ok()) return s.error();
  const double track_s = std::min(o.seconds ? *o.seconds * o.speed : 1e300, track.seconds() - o.from_s);
  const double flight_s = track_s / o.speed;
  // A step of whole milliseconds such that the path holds all poses.
  const double min_step_ms = flight_s * 1000 / static_cast<double>(proto::Path::kMaxPoses - 2);
  const int64_t wanted_ms = track.cameras.empty() ? 100 : 50;  // hands turn a camera more abruptly than wings
  const Duration step =
      Duration::milliseconds(std::max<int64_t>(wanted_ms, static_cast<int64_t>(std::ceil(min_step_ms))));
  if (step > Duration::milliseconds(60'000))
    return Error{ErrorCode::kLimit, "the flight would last more than a month: raise --speed or state --seconds"};
  const double step_s = step.toSeconds() * o.speed;
  const size_t count = static_cast<size_t>(std::ceil(track_s / step_s - 1e-9)) + 1;
  const Steps steps{o.from_s, step_s, std::max<size_t>(count, 2)};
  if (!track.cameras.empty()) {
    PlannedTrack plan = planCamera(track, frame, shape, steps);
    plan.step = step;
    return plan;
  }
  PlannedTrack plan{.step = step};
  if (frame.frame().kind == proto::FrameKind::kGlobe) {
    planOverGlobe(track, frame, steps, plan);
    return plan;
  }
  std::vector<glm::dvec3> points = resample(track, frame.frame(), steps);
  points = boxSmooth(points, static_cast<size_t>(std::lround(kSmooth_s / step_s)));

  const double max_x = shape.samples_x - 1, max_y = shape.samples_y - 1;
  const PathSpan inside = longestSpan(points.size(), [&](size_t i) {
    return points[i].x >= 0 && points[i].x <= max_x && points[i].y >= 0 && points[i].y <= max_y;
  });
  if (inside.count < 2)
    return invalidArgument("the track does not cross the scene's data: see `foreland info` for where the scene lies");
  if (inside.count < points.size())
    plan.notes.push_back(std::to_string(points.size() - inside.count) + " of " + std::to_string(points.size()) +
                         " poses lie outside the data, or apart from the longest stretch inside it; cut off");
  for (size_t i = inside.first; i < inside.first + inside.count; ++i) {
    plan.positions.emplace_back(points[i].x, points[i].y);
    plan.heights_m.push_back(points[i].z);
  }
  return plan;
}

Result<TrackPath> pathOverGround(const PlannedTrack& plan, const proto::FrameTransform& frame,
                                 std::span<const float> ground_m, const TrackOptions& o) {
  const bool has_undulations = !plan.undulations_m.empty() && plan.orientations.empty();
  if (has_undulations && plan.undulations_m.size() != plan.positions.size())
    return Error{ErrorCode::kMalformed, "the server answered " + std::to_string(plan.undulations_m.size()) +
                                            " undulations for " + std::to_string(plan.positions.size()) + " positions"};
  if (ground_m.size() != plan.positions.size() || plan.heights_m.size() != plan.positions.size())
    return Error{ErrorCode::kMalformed, "the server answered " + std::to_string(ground_m.size()) +
                                            " ground heights for " + std::to_string(plan.positions.size()) +
                                            " positions"};
  if (!std::ranges::all_of(ground_m, [](float h) { return std::isfinite(h); }))
    return Error{ErrorCode::kMalformed,
                 "the server knows no ground height at a position of the track that is inside its data"};
  TrackPath result;
  const std::vector<double> heights = heightProfile(plan, ground_m, o, result.lifted);
  std::vector<glm::dvec3> eyes(plan.positions.size());
  for (size_t i = 0; i < eyes.size(); ++i)
    eyes[i] = frame.toScene(proto::LatticePosition{plan.positions[i].x, plan.positions[i].y, heights[i]});
  result.path.step = plan.step;
  result.path.poses.reserve(eyes.size());
  if (plan.orientations.empty()) {
    const std::vector<glm::dvec3> ahead = directions(eyes, frame, plan.step);
    for (size_t i = 0; i < eyes.size(); ++i)
      result.path.poses.push_back(poseAt(eyes[i], ahead[i], frame.upAt(eyes[i])));
  }
  for (size_t i = 0; i < plan.orientations.size(); ++i)
    result.path.poses.push_back(poseOf(eyes[i], plan.orientations[i], plan.positions[i], heights[i], frame));
  if (result.lifted > 0)
    result.notes.push_back(std::to_string(result.lifted) + " of " + std::to_string(eyes.size()) +
                           " poses were lower than " + std::to_string(std::lround(o.clearance_m)) +
                           " m above ground; lifted");
  if (Status s = result.path.validate(); !s.ok()) return s.error();
  return result;
}

}  // namespace foreland::client
