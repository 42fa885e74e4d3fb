#include "server/view/globe_tour.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <string_view>

#include "proto/space/direction.h"
#include "server/view/ground.h"

namespace foreland::server {

namespace {

using std::numbers::pi;
constexpr double kClosest_m = 60;
constexpr double kPace = 0.2;         // of the height, a second
constexpr double kFarthest = 2 * pi;  // radii: 40,000 km above the earth
constexpr std::string_view kDescent = "descent";

// Where a camera is, where it looks along the level, and how far up.
struct Stand {
  Station station;
  glm::dvec3 ahead;
  double pitch_rad;
};

class Planet {
 public:
  explicit Planet(const terrain::Scene& scene) : scene_(scene), transform_(scene.frame()) {}

  double radius() const { return scene_.frame().semi_major_m; }
  proto::Pose poseAt(const Stand& s) const {
    const glm::dvec3& n = s.station.direction;
    proto::LatticePosition at = transform_.toLattice(transform_.spheroid().position(n, 0));
    at.height_m = groundHeight(scene_, at.x, at.y).value_or(0) + s.station.above_m;
    const glm::dvec3 level = glm::normalize(s.ahead - glm::dot(s.ahead, n) * n);
    return {transform_.toScene(at), proto::lookAlong(level * std::cos(s.pitch_rad) + n * std::sin(s.pitch_rad), n)};
  }
  // Towards the highest node of the levels that all scenes have whole, or of the first ten.
  glm::dvec3 towardsHighest() const {
    const proto::GridTopology& grid = scene_.grid();
    const proto::Slot end = grid.levelOffset(std::min(grid.wholeLevels(), 10) + 1);
    proto::NodeId highest = grid.node(0);
    for (proto::Slot slot = 0; slot < end; ++slot) takeHigher(slot, highest);
    return towards(highest);
  }
  // Towards the highest node of the finest pages.
  glm::dvec3 towardsFinest() const {
    const auto blocks = scene_.pages().blocks();
    if (blocks.empty()) return towardsHighest();
    const int finest = std::ranges::max(blocks, {}, &proto::PageBlock::level).level();
    std::optional<proto::NodeId> highest;
    for (const proto::PageBlock& block : blocks)
      if (block.level() == finest)
        scene_.pages().forEachPage(block, [&](proto::Slot first, uint64_t) {
          if (!highest) highest = scene_.grid().node(first);
          for (proto::Slot slot = first; slot < first + proto::kPageSlots; ++slot) takeHigher(slot, *highest);
        });
    return towards(*highest);
  }

 private:
  void takeHigher(proto::Slot slot, proto::NodeId& highest) const {
    const proto::NodeId n = scene_.grid().node(slot);
    if (!scene_.grid().isBase(n) && scene_.height(n) > scene_.height(highest)) highest = n;
  }
  glm::dvec3 towards(proto::NodeId n) const {
    const proto::LatticePosition at{double(n.x()), double(n.y()), 0};
    return transform_.upAt(transform_.toScene(at));
  }

  const terrain::Scene& scene_;
  proto::FrameTransform transform_;
};

glm::dvec3 eastOf(const glm::dvec3& n) {
  return glm::normalize(glm::cross(glm::dvec3(0, 0, 1), n + glm::dvec3(1e-3, 0, 0)));
}

// On the great circle from `from` through `side`, a quarter further, at an angle from the first, looking on.
Stand along(double angle, const glm::dvec3& from, const glm::dvec3& side, double above_m, double pitch_rad) {
  return {{std::cos(angle) * from + std::sin(angle) * side, above_m},
          std::cos(angle) * side - std::sin(angle) * from,
          pitch_rad};
}

// From straight down, far above, to a little down.
double pitchAt(double above_m, double radius) {
  return std::lerp(-0.5 * pi + 0.01, -0.3, 1 / (1 + 200 * above_m / radius));
}

Stand surveyAt(double share, const glm::dvec3& n, double radius) {
  const double above_m = std::exp(std::lerp(std::log(6 * radius), std::log(kClosest_m), share));
  const double near = 1 / (1 + 200 * above_m / radius);
  const glm::dvec3 east = eastOf(n);
  return {{glm::normalize(n + 0.02 * (1 - near) * east), above_m}, east, pitchAt(above_m, radius)};
}

Stand descentAt(double share, const glm::dvec3& n, double radius) {
  const glm::dvec3 east = eastOf(n);
  const Station goal{n, kClosest_m}, start{glm::normalize(n - 1.5 * east), kFarthest * radius};
  const Station at = between(start, goal, share);
  return {at, east, pitchAt(at.above_m, radius)};
}

// What a tour needs to know besides the planet.
struct Course {
  std::string name;
  double seconds;
  glm::dvec3 goal;
};

Stand standAt(const Course& course, double share, double radius) {
  const std::string& name = course.name;
  const glm::dvec3 pole(0, 0, 1), zero(1, 0, 0), east(0, 1, 0), corner = glm::normalize(glm::dvec3(1, 1, 1));
  const glm::dvec3 corner_east = glm::normalize(glm::cross(pole, corner)),
                   corner_north = glm::cross(corner, corner_east);
  if (name == kDescent) return descentAt(share, course.goal, radius);
  if (name == "survey") return surveyAt(share, course.goal, radius);
  if (name == "canyon") return along(std::lerp(-0.5, 0.5, share), pole, zero, 0.002 * radius, -0.3);
  if (name == "spin") {
    const double turn = 2 * pi * share;
    return {{corner, 0.01 * radius}, std::cos(turn) * corner_east + std::sin(turn) * corner_north, -0.3};
  }
  // So far along the ground, radians, by kPace.
  const auto way = [&](double height) { return std::min(2 * pi, kPace * height * course.seconds) * (share - 0.5); };
  if (name == "pole") return along(way(0.01), pole, zero, 0.01 * radius, -0.3);
  if (name == "antimeridian") return along(way(0.15), -zero, pole, 0.15 * radius, -0.7);
  if (name == "corner") return along(way(0.002), corner, corner_north, 0.002 * radius, -0.3);
  if (name == "equator") return along(way(0.55), zero, east, 0.55 * radius, -0.8);
  return along(2 * pi * share, pole, glm::normalize(glm::dvec3(1, 1, 0)), 0.15 * radius, -0.7);
}

// The direction of LAT,LON in degrees.
std::optional<glm::dvec3> placeOf(std::string_view text) {
  std::array<double, 2> degrees{};
  const size_t comma = text.find(',');
  if (comma == std::string_view::npos) return std::nullopt;
  const std::array<std::string_view, 2> parts{text.substr(0, comma), text.substr(comma + 1)};
  for (size_t i = 0; i < 2; ++i) {
    const char* const end = parts[i].data() + parts[i].size();
    const auto [stopped, error] = std::from_chars(parts[i].data(), end, degrees[i]);
    if (error != std::errc{} || stopped != end) return std::nullopt;
  }
  if (!(std::fabs(degrees[0]) <= 90) || !(std::fabs(degrees[1]) <= 360)) return std::nullopt;
  const double latitude = degrees[0] * pi / 180, longitude = degrees[1] * pi / 180;
  return glm::dvec3(std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
                    std::sin(latitude));
}

// What follows `descent:`; nothing for other names.
std::optional<std::string_view> goalOf(std::string_view name) {
  if (!name.starts_with(kDescent) || name.size() <= kDescent.size() || name[kDescent.size()] != ':')
    return std::nullopt;
  return name.substr(kDescent.size() + 1);
}

}  // namespace

Station between(const Station& a, const Station& b, double share) {
  const double above_m = std::exp(std::lerp(std::log(a.above_m), std::log(b.above_m), share));
  const double fallen = a.above_m == b.above_m ? share : (a.above_m - above_m) / (a.above_m - b.above_m);
  return {proto::directionBetween(a.direction, b.direction, fallen), above_m};
}

std::optional<Status> checkGlobeTour(const std::string& name) {
  constexpr std::array<std::string_view, 9> kTours{"survey", "canyon",       "spin",   "orbit",  kDescent,
                                                   "pole",   "antimeridian", "corner", "equator"};
  if (std::ranges::find(kTours, name) != kTours.end()) return Status{};
  const auto goal = goalOf(name);
  if (!goal) return std::nullopt;
  if (placeOf(*goal)) return Status{};
  return Error{ErrorCode::kInvalidArgument,
               "where does the tour descend to? write descent:LAT,LON in degrees, for example descent:46.2,-122.19"};
}

proto::Path planGlobeTour(const terrain::Scene& scene, const std::string& name, size_t poses, Duration step) {
  const Planet planet(scene);
  const double steps = static_cast<double>(std::max<size_t>(poses, 2) - 1);
  Course course{name, steps * step.toSeconds(), {}};
  if (const auto goal = goalOf(name))
    course.name = kDescent, course.goal = *placeOf(*goal);
  else if (name == kDescent)
    course.goal = planet.towardsFinest();
  else if (name == "survey")
    course.goal = planet.towardsHighest();
  proto::Path path{Time{}, step, {}};
  for (size_t i = 0; i < poses; ++i)
    path.poses.push_back(planet.poseAt(standAt(course, static_cast<double>(i) / steps, planet.radius())));
  return path;
}

}  // namespace foreland::server
