#include "server/view/globe_tour.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "server/view/ground.h"

namespace foreland::server {

namespace {

constexpr double kClosest_m = 60;

// Where a camera is: the direction below it, how high above the ground, where it looks along the level, and how far up.
struct Station {
  glm::dvec3 direction;
  double above_m;
  glm::dvec3 ahead;
  double pitch_rad;
};

class Planet {
 public:
  explicit Planet(const terrain::Scene& scene) : scene_(scene), transform_(scene.frame()) {}

  double radius() const { return scene_.frame().semi_major_m; }
  proto::Pose poseAt(const Station& s) const {
    const glm::dvec3 n = glm::normalize(s.direction);
    proto::LatticePosition at = transform_.toLattice(transform_.spheroid().position(n, 0));
    at.height_m = groundHeight(scene_, at.x, at.y).value_or(0) + s.above_m;
    const glm::dvec3 level = glm::normalize(s.ahead - glm::dot(s.ahead, n) * n);
    return {transform_.toScene(at), proto::lookAlong(level * std::cos(s.pitch_rad) + n * std::sin(s.pitch_rad), n)};
  }
  // Towards the highest node of the levels that all scenes have whole, or of the first ten.
  glm::dvec3 towardsHighest() const {
    const proto::GridTopology& grid = scene_.grid();
    const proto::Slot end = grid.levelOffset(std::min(grid.wholeLevels(), 10) + 1);
    proto::NodeId highest = grid.node(0);
    for (proto::Slot slot = 0; slot < end; ++slot)
      if (const proto::NodeId n = grid.node(slot); !grid.isBase(n) && scene_.height(n) > scene_.height(highest))
        highest = n;
    return transform_.toScene(proto::LatticePosition{double(highest.x()), double(highest.y()), 0});
  }

 private:
  const terrain::Scene& scene_;
  proto::FrameTransform transform_;
};

// On the great circle through the pole and `side`, at an angle from the pole, looking on.
Station overThePole(double angle, const glm::dvec3& side, double above_m, double pitch_rad) {
  const glm::dvec3 pole(0, 0, 1);
  return {std::cos(angle) * pole + std::sin(angle) * side, above_m, std::cos(angle) * side - std::sin(angle) * pole,
          pitch_rad};
}

Station surveyAt(double share, const glm::dvec3& target, double radius) {
  const double above_m = std::exp(std::lerp(std::log(6 * radius), std::log(kClosest_m), share));
  const double near = 1 / (1 + 200 * above_m / radius);  // from 0, far above, to 1
  const glm::dvec3 east = glm::normalize(glm::cross(glm::dvec3(0, 0, 1), target + glm::dvec3(1e-3, 0, 0)));
  const double aside = 0.02 * (1 - near);
  return {glm::normalize(target) + aside * east, above_m, east, std::lerp(-0.5 * std::numbers::pi + 0.01, -0.3, near)};
}

Station stationAt(const std::string& name, double share, const Planet& planet, const glm::dvec3& highest) {
  const double radius = planet.radius();
  if (name == "survey") return surveyAt(share, highest, radius);
  if (name == "canyon") return overThePole(std::lerp(-0.5, 0.5, share), {1, 0, 0}, 0.002 * radius, -0.3);
  const glm::dvec3 corner = glm::normalize(glm::dvec3(1, 1, 1));
  if (name == "spin") {
    const glm::dvec3 east = glm::normalize(glm::cross(glm::dvec3(0, 0, 1), corner)), north = glm::cross(corner, east);
    const double turn = 2 * std::numbers::pi * share;
    return {corner, 0.01 * radius, std::cos(turn) * east + std::sin(turn) * north, -0.3};
  }
  return overThePole(2 * std::numbers::pi * share, glm::normalize(glm::dvec3(1, 1, 0)), 0.15 * radius, -0.7);
}

}  // namespace

proto::Path planGlobeTour(const terrain::Scene& scene, const std::string& name, size_t poses, Duration step) {
  const Planet planet(scene);
  const glm::dvec3 highest = planet.towardsHighest();
  proto::Path path{Time{}, step, {}};
  for (size_t i = 0; i < poses; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(std::max<size_t>(poses, 2) - 1);
    path.poses.push_back(planet.poseAt(stationAt(name, share, planet, highest)));
  }
  return path;
}

}  // namespace foreland::server
