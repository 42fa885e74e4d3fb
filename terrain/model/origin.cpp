#include "terrain/model/origin.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace foreland::terrain {

namespace {

constexpr double kFar = 10'000, kFarInDiagonals = 10;

}  // namespace

glm::dvec3 ownOrigin(const Model& model) {
  if (model.corners.empty()) return glm::dvec3(0);
  glm::dvec3 low = model.positions[model.corners.front().vertex], high = low;
  for (const Corner& corner : model.corners) {
    low = glm::min(low, model.positions[corner.vertex]);
    high = glm::max(high, model.positions[corner.vertex]);
  }
  const glm::dvec3 nearest = glm::clamp(glm::dvec3(0), low, high);
  if (glm::length(nearest) <= std::max(kFar, kFarInDiagonals * glm::length(high - low))) return glm::dvec3(0);
  return {std::round((low.x + high.x) / 2), std::round((low.y + high.y) / 2), std::floor(low.z)};
}

void moveTo(const glm::dvec3& origin, Model& model) {
  if (origin == glm::dvec3(0)) return;
  for (glm::dvec3& p : model.positions) p -= origin;
}

}  // namespace foreland::terrain
