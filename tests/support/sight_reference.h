// Lines of sight the plainest way, for tests of those that are fast: the bent way of light is cut into pieces so short
// that nothing fits between them and it, and each piece is tried, in the form of Moeller and Trumbore 1997, on every
// triangle, or on every one near it. Knows nothing of trees, of blocks, or of a line's own coordinates.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <vector>

#include "proto/space/frame.h"
#include "proto/topology/mesh_triangles.h"
#include "server/section/hierarchy.h"
#include "server/sight/sight_scene.h"

namespace foreland::test {

using Corners = std::array<glm::dvec3, 3>;

// Of the first of both ends: a share of the way from `from` to `to`, or nothing.
inline std::optional<double> meetPlainly(const glm::dvec3& from, const glm::dvec3& to, const Corners& t) {
  const glm::dvec3 way = to - from, u = t[1] - t[0], v = t[2] - t[0], p = glm::cross(way, v);
  const double determinant = glm::dot(u, p);
  if (determinant == 0) return std::nullopt;
  const glm::dvec3 to_from = from - t[0], q = glm::cross(to_from, u);
  const double a = glm::dot(to_from, p) / determinant, b = glm::dot(way, q) / determinant;
  const double share = glm::dot(v, q) / determinant;
  if (a < 0 || b < 0 || a + b > 1 || share < 0 || share > 1) return std::nullopt;
  return share;
}

// The ground of a still scene as its finest triangles: each square of 2 x 2 cells is a fan about its centre.
class PlainGround {
 public:
  explicit PlainGround(const terrain::Scene& scene)
      : scene_(scene), transform_(scene.frame()), shape_(scene.grid().shape()) {}

  const proto::FrameTransform& transform() const { return transform_; }
  glm::dvec3 sample(int64_t x, int64_t y) const {
    const auto at = proto::NodeId::at(static_cast<uint32_t>(x), static_cast<uint32_t>(y));
    return transform_.toScene(proto::LatticePosition{static_cast<double>(x), static_cast<double>(y),
                                                     scene_.height(at) * scene_.frame().height_quantum_m});
  }
  // Calls visit(Corners) for both triangles of a cell, if there is such a cell.
  template <class Visit>
  void forCell(int64_t x, int64_t y, const Visit& visit) const {
    if (x < 0 || y < 0 || x + 1 >= shape_.samples_x || y + 1 >= shape_.samples_y) return;
    const int64_t odd_x = x | 1, odd_y = y | 1;  // of a cell one corner's coordinates are both odd: the fan's centre
    const int64_t even_x = 2 * x + 1 - odd_x, even_y = 2 * y + 1 - odd_y;
    const glm::dvec3 centre = sample(odd_x, odd_y), corner = sample(even_x, even_y);
    visit(Corners{centre, corner, sample(odd_x, even_y)});
    visit(Corners{centre, corner, sample(even_x, odd_y)});
  }
  template <class Visit>
  void forAll(const Visit& visit) const {
    for (int64_t y = 0; y + 1 < shape_.samples_y; ++y)
      for (int64_t x = 0; x + 1 < shape_.samples_x; ++x) forCell(x, y, visit);
  }
  // On the triangles.
  std::optional<double> heightAt(double x, double y) const {
    std::optional<double> height;
    const auto cell_x = std::min<int64_t>(static_cast<int64_t>(x), shape_.samples_x - 2),
               cell_y = std::min<int64_t>(static_cast<int64_t>(y), shape_.samples_y - 2);
    const glm::dvec3 low = transform_.toScene(proto::LatticePosition{x, y, -2e4}),
                     high = transform_.toScene(proto::LatticePosition{x, y, 2e4});
    for (int64_t j = -1; j <= 1; ++j)
      for (int64_t i = -1; i <= 1; ++i)
        forCell(cell_x + i, cell_y + j, [&](const Corners& t) {
          if (const auto share = meetPlainly(low, high, t)) height = -2e4 + *share * 4e4;
        });
    return height;
  }

 private:
  const terrain::Scene& scene_;
  proto::FrameTransform transform_;
  proto::GridShape shape_;
};

// Every triangle of the objects of a scene, as they stand at the first epoch.
inline std::vector<Corners> trianglesOf(const server::SceneObjects& objects) {
  std::vector<Corners> triangles;
  for (size_t object = 0; object < objects.set.size(); ++object) {
    const proto::MeshTopology& mesh = objects.set.domain(object).topology();
    const proto::ObjectModel& model = objects.set.modelOf(object);
    const auto at = [&](proto::NodeId v) {
      const glm::ivec3 quanta =
          mesh.isBase(v) ? model.base[proto::baseVertexOf(v)] : objects.recordsOf(object)[mesh.slot(v)].position;
      return objects.set.placement(object).toScene(glm::dvec3(quanta) * model.quantum_m);
    };
    proto::forEachTriangle(
        mesh, [](proto::NodeId) { return true; },
        [&](proto::NodeId a, proto::NodeId b, proto::NodeId c) {
          triangles.push_back({at(a), at(b), at(c)});
        });
  }
  return triangles;
}

// The way of light as docs/PROTOCOL.md has it (section 19).
struct PlainLine {
  const proto::FrameTransform& transform;
  glm::dvec3 from, to;
  double refraction = 0;

  glm::dvec3 at(double share) const {
    constexpr double kRadius_m = 6'371'008.8;
    const glm::dvec3 up = transform.upAt((from + to) / 2.0), way = to - from;
    const double distance_m = glm::length(way - glm::dot(way, up) * up);
    const double bent = transform.frame().kind == proto::FrameKind::kPlanar ? 1 - refraction : -refraction;
    const double sag_m = bent * distance_m * distance_m / (8 * kRadius_m);
    return from + share * way - up * (4 * sag_m * share * (1 - share));
  }
};

// The first share of the way, 1 mm from the ends, at which one of the triangles that `near(middle of a piece, visit)`
// visits hides the end.
template <class Near>
std::optional<double> firstHitPlainly(const PlainLine& line, int pieces, const Near& near) {
  const double length_m = glm::distance(line.from, line.to), ends = 1e-3 / length_m;
  for (int i = 0; i < pieces; ++i) {
    const double begin = static_cast<double>(i) / pieces, end = static_cast<double>(i + 1) / pieces;
    const glm::dvec3 from = line.at(begin), to = line.at(end);
    std::optional<double> first;
    near((from + to) / 2.0, [&](const Corners& t) {
      const auto share = meetPlainly(from, to, t);
      if (!share) return;
      const double whole = begin + *share * (end - begin);
      if (whole > ends && whole < 1 - ends && (!first || whole < *first)) first = whole;
    });
    if (first) return first;
  }
  return std::nullopt;
}

// Whether a point is within a millimetre of a triangle that `near(point, visit)` visits.
template <class Near>
bool isOnTriangle(const glm::dvec3& point, const Near& near) {
  bool is_on = false;
  near(point, [&](const Corners& t) {
    const glm::dvec3 across = 1e-3 * glm::normalize(glm::cross(t[1] - t[0], t[2] - t[0]));
    is_on = is_on || meetPlainly(point - across, point + across, t);
  });
  return is_on;
}

// Whether both say the same. Where light comes nearly along a triangle, rounding moves the point where they meet: there
// the point that was found must lie on a triangle.
template <class Near>
bool isSame(const std::optional<server::SightHit>& found, const std::optional<double>& expected, const PlainLine& line,
            const Near& near) {
  if (found.has_value() != expected.has_value()) return false;
  if (!found) return true;
  const double apart_m = std::fabs(found->share - *expected) * glm::distance(line.from, line.to);
  return apart_m < 0.01 || (apart_m < 1 && isOnTriangle(found->position, near));
}

// Whether an answer that differs from the plain walk's is as right: lines whose ends are up to a centimetre away have
// answers on both sides of it, and what was found lies on a triangle.
template <class Ask, class Near>
bool isGrazing(const std::optional<server::SightHit>& found, const PlainLine& line, const Ask& firstHit,
               const Near& near) {
  constexpr double kNone = 2;  // a share beyond the line's end
  const glm::dvec3 up = line.transform.upAt(line.from), side = glm::normalize(glm::cross(up, line.to - line.from));
  double nearest = kNone, farthest = 0;
  for (const glm::dvec3& shift : {up, -up, side, -side}) {
    const PlainLine shifted{line.transform, line.from + 0.01 * shift, line.to + 0.01 * shift, line.refraction};
    const double share = firstHit(shifted).value_or(kNone);
    nearest = std::min(nearest, share);
    farthest = std::max(farthest, share);
  }
  if (!found) return farthest == kNone;
  return nearest <= found->share && found->share <= farthest && isOnTriangle(found->position, near);
}

// Whether an answer is what firstHit(line), a plain walk, finds, or as right; `grazing` counts the answers that differ.
template <class Ask, class Near>
testing::AssertionResult isAsPlainly(const std::optional<server::SightHit>& found, const PlainLine& line,
                                     const Ask& firstHit, const Near& near, int& grazing) {
  const std::optional<double> expected = firstHit(line);
  if (isSame(found, expected, line, near)) return testing::AssertionSuccess();
  ++grazing;
  if (isGrazing(found, line, firstHit, near)) return testing::AssertionSuccess();
  return testing::AssertionFailure() << (found ? found->share : -1) << ", plainly " << expected.value_or(-1) << " of "
                                     << glm::distance(line.from, line.to) << " m";
}

}  // namespace foreland::test
