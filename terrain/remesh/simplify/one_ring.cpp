#include "terrain/remesh/simplify/one_ring.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "base/check.h"
#include "terrain/remesh/original/surface_point.h"
#include "terrain/remesh/original/triangulate.h"

namespace foreland::terrain {

namespace {

double angleAt(const glm::dvec3& apex, const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a - apex, b - apex)), glm::dot(a - apex, b - apex));
}

// Scales the angles from ring vertex `from` to `to`, cyclically, so that they sum to `total`.
void scaleAngles(std::vector<double>& angles, size_t from, size_t to, double total) {
  double sum = 0;
  for (size_t i = from; i != to; i = (i + 1) % angles.size()) sum += angles[i];
  for (size_t i = from; i != to; i = (i + 1) % angles.size()) angles[i] *= total / sum;
}

}  // namespace

void gatherOneRing(uint32_t centre, std::span<const uint32_t> faces_at, const std::vector<Triangle>& faces,
                   OneRing& ring) {
  const size_t count = faces_at.size();
  const auto cornerIn = [&](uint32_t face) {
    const Triangle& t = faces[face];
    return static_cast<uint8_t>(t[0] == centre ? 0 : t[1] == centre ? 1 : 2);
  };
  const auto side = [&](uint32_t face, uint32_t step) { return faces[face][(cornerIn(face) + step) % 3]; };
  const auto find = [&](uint32_t vertex, uint32_t step) {
    for (uint32_t face : faces_at)
      if (side(face, step) == vertex) return face;
    return kNoIndex;
  };
  // An open ring begins with the face that no other precedes; a closed one with the face of the lowest index.
  uint32_t first = *std::min_element(faces_at.begin(), faces_at.end());
  ring.is_open = false;
  for (uint32_t face : faces_at)
    if (find(side(face, 1), 2) == kNoIndex) first = face, ring.is_open = true;
  ring.vertices.clear(), ring.faces.clear(), ring.corners.clear();
  uint32_t face = first;
  for (size_t i = 0; i < count; ++i) {
    CHECK_NE(face, kNoIndex);
    ring.vertices.push_back(side(face, 1));
    ring.faces.push_back(face);
    ring.corners.push_back(cornerIn(face));
    if (i + 1 == count && ring.is_open) ring.vertices.push_back(side(face, 2));
    face = find(side(face, 2), 1);
  }
}

bool flatten(uint32_t centre, const OneRing& ring, StraightPath path, const std::vector<glm::dvec3>& positions,
             std::vector<glm::dvec2>& flat) {
  constexpr double kPi = std::numbers::pi;
  const glm::dvec3& apex = positions[centre];
  std::vector<double> angles(ring.size(), 0.0);
  double sum = 0;
  for (size_t i = 0; i < ring.faces.size(); ++i)
    sum += angles[i] = angleAt(apex, positions[ring.vertices[i]], positions[ring.next(i)]);
  if (path[0] != path[1]) {
    scaleAngles(angles, path[0], path[1], kPi);
    scaleAngles(angles, path[1], path[0], kPi);
  } else {
    for (double& angle : angles) angle *= (ring.is_open ? kPi : 2 * kPi) / sum;
  }
  flat.resize(ring.size());
  double direction = 0;
  for (size_t i = 0; i < ring.size(); ++i) {
    flat[i] = glm::distance(apex, positions[ring.vertices[i]]) * glm::dvec2(std::cos(direction), std::sin(direction));
    direction += angles[i];
  }
  constexpr double kWidest = kPi * 0.995;  // a face with a wider angle at the centre counts as flipped
  return std::all_of(angles.begin(), angles.end(), [](double angle) { return angle < kWidest; });
}

bool isValidFan(const std::vector<glm::dvec2>& flat, size_t kept, bool is_open, double min_quality) {
  const size_t n = flat.size();
  for (size_t step = 1; step + 1 < n; ++step) {
    const size_t i = (kept + step) % n, j = (kept + step + 1) % n;
    if (is_open && j == 0) continue;  // the gap between the two ends of an open ring
    const glm::dvec2 &a = flat[kept], &b = flat[i], &c = flat[j];
    if (doubledArea(a, b, c) <= 0) return false;
    if (triangleQuality({a, 0}, {b, 0}, {c, 0}) < min_quality) return false;
  }
  return true;
}

}  // namespace foreland::terrain
