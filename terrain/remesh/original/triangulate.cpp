#include "terrain/remesh/original/triangulate.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>

namespace foreland::terrain {

namespace {

using glm::dvec3;
using Indices = std::array<uint32_t, 3>;

constexpr double kThinnest = 1e-12;  // doubled area as a share of the squared longest side; rounding alone gives 1e-15

// Whether the triangle has an area and the same orientation as the polygon.
bool faces(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& normal) {
  const dvec3 area = glm::cross(b - a, c - a);
  const double longest = std::max({glm::dot(b - a, b - a), glm::dot(c - b, c - b), glm::dot(a - c, a - c)});
  return glm::length(area) > kThinnest * longest && glm::dot(area, normal) > 0;
}

bool isInside(const dvec3& p, const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& normal) {
  const auto left = [&](const dvec3& from, const dvec3& to) {
    return glm::dot(glm::cross(to - from, p - from), normal) >= 0;
  };
  return left(a, b) && left(b, c) && left(c, a);
}

class EarClipper {
 public:
  EarClipper(std::span<const dvec3> outline, const MayJoin& may_join)
      : points_(outline), may_join_(may_join), normal_(vectorArea(outline)) {
    left_.resize(outline.size());
    std::iota(left_.begin(), left_.end(), 0);
  }
  std::vector<Indices> clip() {
    std::vector<Indices> triangles;
    while (left_.size() > 3) {
      const size_t ear = bestEar();
      if (ear == left_.size()) return {};
      triangles.push_back(corners(ear));
      left_.erase(left_.begin() + static_cast<ptrdiff_t>(ear));
    }
    if (!isFacing(corners(1))) return {};
    triangles.push_back(corners(1));
    return triangles;
  }

 private:
  Indices corners(size_t ear) const {
    const size_t n = left_.size();
    return {left_[(ear + n - 1) % n], left_[ear], left_[(ear + 1) % n]};
  }
  bool isFacing(const Indices& t) const { return faces(points_[t[0]], points_[t[1]], points_[t[2]], normal_); }
  bool isEar(const Indices& t) const {
    if (!isFacing(t) || !may_join_(t[0], t[2])) return false;
    return std::none_of(left_.begin(), left_.end(), [&](uint32_t p) {
      return p != t[0] && p != t[1] && p != t[2] &&
             isInside(points_[p], points_[t[0]], points_[t[1]], points_[t[2]], normal_);
    });
  }
  size_t bestEar() const {
    size_t best = left_.size();
    double best_quality = -1;
    for (size_t ear = 0; ear < left_.size(); ++ear) {
      const Indices t = corners(ear);
      const double quality = triangleQuality(points_[t[0]], points_[t[1]], points_[t[2]]);
      if (quality > best_quality && isEar(t)) best = ear, best_quality = quality;
    }
    return best;
  }

  std::span<const dvec3> points_;
  const MayJoin& may_join_;
  dvec3 normal_;
  std::vector<uint32_t> left_;
};

// By the diagonal that maximises the quality of the worse triangle.
std::vector<Indices> cutQuadrangle(std::span<const dvec3> p, const MayJoin& may_join) {
  constexpr std::array<std::array<Indices, 2>, 2> kCuts{{{{{0, 1, 2}, {0, 2, 3}}}, {{{1, 2, 3}, {1, 3, 0}}}}};
  const dvec3 normal = vectorArea(p);
  std::vector<Indices> best;
  double best_quality = -1;
  for (const auto& cut : kCuts) {
    if (!may_join(cut[0][0], cut[0][2])) continue;
    double worst = 1;
    for (const Indices& t : cut)
      worst =
          std::min(worst, faces(p[t[0]], p[t[1]], p[t[2]], normal) ? triangleQuality(p[t[0]], p[t[1]], p[t[2]]) : -1);
    if (worst > best_quality) best.assign(cut.begin(), cut.end()), best_quality = worst;
  }
  return best;
}

}  // namespace

dvec3 vectorArea(std::span<const dvec3> outline) {
  dvec3 sum(0);
  for (size_t i = 1; i + 1 < outline.size(); ++i)
    sum += glm::cross(outline[i] - outline[0], outline[i + 1] - outline[0]);
  return sum;
}

double triangleQuality(const dvec3& a, const dvec3& b, const dvec3& c) {
  const double sides = glm::dot(b - a, b - a) + glm::dot(c - b, c - b) + glm::dot(a - c, a - c);
  return sides > 0 ? 2 * std::numbers::sqrt3 * glm::length(glm::cross(b - a, c - a)) / sides : 0;
}

bool isLine(std::span<const dvec3> outline) {
  const dvec3 origin = outline.front();
  dvec3 furthest = origin;
  for (const dvec3& p : outline)
    if (glm::distance(p, origin) > glm::distance(furthest, origin)) furthest = p;
  const dvec3 along = furthest - origin;
  return std::all_of(outline.begin(), outline.end(), [&](const dvec3& p) {
    return glm::length(glm::cross(along, p - origin)) <= kThinnest * glm::dot(along, along);
  });
}

std::vector<Indices> triangulate(std::span<const dvec3> outline, const MayJoin& may_join) {
  if (outline.size() == 4) return cutQuadrangle(outline, may_join);
  return EarClipper(outline, may_join).clip();
}

}  // namespace foreland::terrain
