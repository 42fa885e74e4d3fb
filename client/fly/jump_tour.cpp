#include "client/fly/jump_tour.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>

namespace foreland::client {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kBorder_m = 500;           // between a view's flight and the border of the data, if there is room
constexpr double kPitch_rad = -0.2;         // looking a little down
constexpr double kTurn_rad = 1.9;           // from view to view
constexpr double kYaw_rad = 5 * kPi / 180;  // a second, in flight

// The rectangle of the data in the plane of the scene frame.
struct Rectangle {
  glm::dvec2 low, high;

  bool contains(glm::dvec2 p) const {
    const glm::dvec2 border = glm::min(glm::dvec2(kBorder_m), 0.1 * (high - low));
    return p.x > low.x + border.x && p.y > low.y + border.y && p.x < high.x - border.x && p.y < high.y - border.y;
  }
};

Rectangle rectangleOf(const proto::FrameTransform& frame, const proto::GridShape& shape) {
  const glm::dvec3 a = frame.toScene(proto::LatticePosition{0, 0, 0}),
                   b = frame.toScene(proto::LatticePosition{shape.samples_x - 1.0, shape.samples_y - 1.0, 0});
  return {glm::min(glm::dvec2(a), glm::dvec2(b)), glm::max(glm::dvec2(a), glm::dvec2(b))};
}

// A point `distance` from `from` inside the data, in the direction that leaves most room for the next jump.
std::optional<glm::dvec2> jumpFrom(const Rectangle& data, glm::dvec2 from, double distance) {
  const glm::dvec2 middle = 0.5 * (data.low + data.high);
  std::optional<glm::dvec2> best;
  for (int i = 0; i < 16; ++i) {
    const glm::dvec2 to = from + distance * glm::dvec2(std::cos(i * kPi / 8), std::sin(i * kPi / 8));
    if (data.contains(to) && (!best || glm::distance(to, middle) < glm::distance(*best, middle))) best = to;
  }
  return best;
}

struct Kind {
  std::string name;
  double distance_m;
};

std::vector<Kind> kindsFor(const Rectangle& data) {
  const glm::dvec2 size = data.high - data.low;
  const double half = 0.5 * std::max(size.x, size.y);
  std::vector<Kind> kinds;
  for (const double km : {1.0, 3.0, 12.0, 48.0})
    if (1000 * km < 0.75 * std::max(size.x, size.y)) kinds.push_back({std::to_string(int(km)) + " km", 1000 * km});
  kinds.push_back({"half the scene", half});
  return kinds;
}

double secondsOf(Duration t) { return t.toSeconds(); }

}  // namespace

void JumpTour::jumpOverData(const proto::GridShape& shape, size_t wanted) {
  const Rectangle data = rectangleOf(frame_, shape);
  const std::vector<Kind> kinds = kindsFor(data);
  glm::dvec2 at = data.low + 0.3 * (data.high - data.low);
  double heading = 0.4;
  views_.push_back({"", glm::dvec3(at, 0), heading});
  for (size_t i = 0, skipped = 0; views_.size() < wanted && skipped < kinds.size(); ++i) {
    const Kind& kind = kinds[i % kinds.size()];
    const auto next = jumpFrom(data, at, kind.distance_m);
    if (!next) {
      ++skipped;
      continue;
    }
    skipped = 0;
    at = *next;
    heading += kTurn_rad;
    views_.push_back({kind.name, glm::dvec3(at, 0), heading});
  }
}

JumpTour::View JumpTour::viewOverGlobe(std::string kind, const glm::dvec3& n, double heading_rad) const {
  const glm::dvec3 aside = glm::cross(glm::dvec3(0, 0, 1), n), east = glm::normalize(aside);
  return {std::move(kind), frame_.spheroid().position(n, 0), heading_rad, east, glm::cross(n, east), n};
}

void JumpTour::jumpOverGlobe(size_t wanted) {
  const double radius = frame_.frame().semi_major_m;
  std::vector<Kind> kinds;
  for (const double km : {1.0, 3.0, 12.0, 48.0, 1000.0})
    if (1000 * km < 0.75 * radius) kinds.push_back({std::to_string(int(km)) + " km", 1000 * km});
  kinds.push_back({"the other side", 0.9 * kPi * radius});
  views_.push_back(viewOverGlobe("", glm::normalize(glm::dvec3(0.70, 0.12, 0.71)), 0.4));
  for (size_t i = 0; views_.size() < wanted; ++i) {
    const View& last = views_.back();
    const double angle = kinds[i % kinds.size()].distance_m / radius;
    const glm::dvec3 n = glm::normalize(std::cos(angle) * last.up + std::sin(angle) * last.along());
    views_.push_back(viewOverGlobe(kinds[i % kinds.size()].name, n, last.heading_rad + kTurn_rad));
  }
}

void JumpTour::placeSamples() {
  for (const View& view : views_)
    for (size_t k = 0; k < kSamples; ++k) {
      const double way = kSpeed_mps * secondsOf(kEvery) * static_cast<double>(k) / (kSamples - 1);
      const proto::LatticePosition at = frame_.toLattice(view.eye + way * view.along());
      positions_.emplace_back(at.x, at.y);
    }
}

Result<JumpTour> JumpTour::plan(const proto::FrameTransform& frame, const proto::GridShape& shape, double seconds) {
  JumpTour tour(frame);
  const auto wanted = std::max<size_t>(static_cast<size_t>(std::ceil(std::max(1.0, seconds) / secondsOf(kEvery))), 2);
  if (frame.frame().kind == proto::FrameKind::kGlobe)
    tour.jumpOverGlobe(wanted);
  else
    tour.jumpOverData(shape, wanted);
  if (tour.views_.size() < 2)
    return Error{ErrorCode::kUnsupported, "the scene is too small for the tour 'jumps'; choose another tour"};
  tour.placeSamples();
  return tour;
}

void JumpTour::setGround(std::span<const float> heights_m) {
  for (size_t i = 0; i < views_.size(); ++i) {
    double highest = 0;
    for (size_t k = 0; k < kSamples; ++k) {
      const float height = i * kSamples + k < heights_m.size() ? heights_m[i * kSamples + k] : 0;
      highest = std::max(highest, std::isfinite(height) ? double{height} : 0.0);
    }
    const glm::dvec2 p = positions_[i * kSamples];
    views_[i].eye = frame_.toScene(proto::LatticePosition{p.x, p.y, highest + kAboveGround_m});
  }
}

size_t JumpTour::viewAt(Duration t) const {
  const int64_t view = std::max<int64_t>(t.us, 0) / kEvery.us;
  return std::min(static_cast<size_t>(view), views_.size() - 1);
}

proto::Pose JumpTour::at(Duration t) const {
  const size_t i = viewAt(t);
  const View& view = views_[i];
  const double s = secondsOf(std::max(t - kEvery * static_cast<int64_t>(i), Duration{}));
  const double yaw = view.heading_rad + kYaw_rad * s;
  const glm::dvec3 forward = std::cos(yaw) * std::cos(kPitch_rad) * view.east +
                             std::sin(yaw) * std::cos(kPitch_rad) * view.north + std::sin(kPitch_rad) * view.up;
  return {view.eye + kSpeed_mps * s * view.along(), proto::lookAlong(forward, view.up)};
}

void JumpReports::count(const JumpTour& tour, size_t view, Duration since_jump, bool shows_view, float tolerance_px,
                        double wanted_px) {
  if (view == 0) return;
  const std::string& kind = tour.kindOf(view);
  auto at = std::find_if(reports_.begin(), reports_.end(), [&](const JumpReport& r) { return r.kind == kind; });
  if (at == reports_.end()) at = reports_.insert(at, JumpReport{.kind = kind});
  if (view != view_) {
    view_ = view;
    is_guaranteed_ = is_recovered_ = false;
    ++at->jumps;
  }
  const bool is_guaranteed = shows_view && std::isfinite(tolerance_px);
  if (!is_guaranteed_) at->worst_without = std::max(at->worst_without, since_jump);
  if (is_guaranteed) at->largest_tolerance_px = std::max(at->largest_tolerance_px, tolerance_px);
  if (since_jump > kFirstPicture && !(is_guaranteed && tolerance_px <= kCoarse_px)) ++at->late_coarse_frames;
  is_guaranteed_ = is_guaranteed_ || is_guaranteed;
  if (is_recovered_) return;
  at->worst_recovery = std::max(at->worst_recovery, since_jump);
  if (!is_guaranteed || tolerance_px > wanted_px * (1 + 1e-6)) return;
  is_recovered_ = true;
  ++at->recovered;
  at->mean_recovery = Duration{at->mean_recovery.us + (since_jump.us - at->mean_recovery.us) / at->recovered};
}

}  // namespace foreland::client
