#include "terrain/remesh/solids/directions.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <tuple>

#include "terrain/surface/inner_solids.h"

namespace foreland::terrain {

namespace {

using glm::dvec3;

constexpr double kSameCosine = 0.985;  // of 10 degrees: normals of one side
constexpr size_t kMaxSides = 48;       // that are told apart
constexpr size_t kSlopes = 6;          // the largest sides beside the box's

// Normals that are nearly the same, and the area that has them.
struct Side {
  dvec3 sum{0};
  double area = 0;
  dvec3 direction() const { return glm::normalize(sum); }
};

std::vector<Side> sidesOf(const FullMesh& mesh) {
  std::vector<Side> sides;
  for (uint32_t t = 0; t < mesh.triangles().size(); ++t) {
    const dvec3& normal = mesh.normal(t);
    if (normal == dvec3(0)) continue;
    const auto& [a, b, c] = mesh.triangles()[t];
    const double area =
        glm::length(glm::cross(mesh.position(b) - mesh.position(a), mesh.position(c) - mesh.position(a)));
    const auto isSame = [&](const Side& s) { return glm::dot(s.sum, normal) > kSameCosine * glm::length(s.sum); };
    const auto same = std::ranges::find_if(sides, isSame);
    if (same != sides.end())
      same->sum += area * normal, same->area += area;
    else if (sides.size() < kMaxSides)
      sides.push_back({area * normal, area});
  }
  std::ranges::sort(sides, [](const Side& a, const Side& b) {
    return std::tuple(b.area, a.sum.x, a.sum.y, a.sum.z) < std::tuple(a.area, b.sum.x, b.sum.y, b.sum.z);
  });
  return sides;
}

// Across the largest wall, level.
dvec3 forwardOf(const std::vector<Side>& sides) {
  for (const Side& side : sides) {
    const dvec3 n = side.direction();
    if (std::fabs(n.z) < 0.5) return glm::normalize(dvec3(n.x, n.y, 0));
  }
  return {1, 0, 0};
}

}  // namespace

Directions chooseDirections(const FullMesh& mesh) {
  const std::vector<Side> sides = sidesOf(mesh);
  const dvec3 forward = forwardOf(sides), up(0, 0, 1), aside = glm::cross(up, forward);
  Directions directions;
  directions.all = {forward, -forward, aside, -aside, up, -up};
  const std::vector<uint32_t> box{0, 1, 2, 3, 4, 5};
  directions.sets = {box};
  std::vector<uint32_t> slopes, largest;
  for (const Side& side : sides) {
    const dvec3 n = -side.direction();
    const auto isSame = [&](const dvec3& other) { return glm::dot(other, n) > kSameCosine; };
    const auto same = std::ranges::find_if(directions.all, isSame);
    const auto index = static_cast<uint32_t>(same - directions.all.begin());
    if (same == directions.all.end()) {
      if (slopes.size() == kSlopes) continue;
      slopes.push_back(index);
      directions.all.push_back(n);
    }
    if (largest.size() < ConvexSolid::kMaxPlanes && std::ranges::find(largest, index) == largest.end())
      largest.push_back(index);
  }
  // The box with two of the slopes, as a roof has them.
  for (size_t i = 0; i + 1 < slopes.size() && i < 4; i += 2) {
    std::vector<uint32_t> with = box;
    with.insert(with.end(), {slopes[i], slopes[i + 1]});
    directions.sets.push_back(std::move(with));
  }
  directions.sets.push_back(std::move(largest));
  return directions;
}

}  // namespace foreland::terrain
