#include "client/ground/ray.h"

#include <algorithm>
#include <glm/geometric.hpp>

namespace foreland::client {
namespace {

constexpr int kSteps = 4096, kHalvings = 40;

struct Span {
  double begin, end;  // metres along the ray; empty if begin is not before end
};

// Within the box and a metre about it.
Span insideBox(const glm::dvec3& low, const glm::dvec3& high, const glm::dvec3& from, const glm::dvec3& step,
               double far_m) {
  Span span{0, far_m};
  for (int i = 0; i < 3; ++i) {
    const double a = low[i] - 1 - from[i], b = high[i] + 1 - from[i];
    if (step[i] == 0) {
      if (a > 0 || b < 0) return {0, 0};
      continue;
    }
    const auto [begin, end] = std::minmax({a / step[i], b / step[i]});
    span = {std::max(span.begin, begin), std::min(span.end, end)};
  }
  return span;
}

}  // namespace

std::optional<glm::dvec3> rayOnGround(const GroundHeights& ground, const proto::FrameTransform& frame,
                                      const glm::dvec3& low, const glm::dvec3& high, const Ray& ray) {
  const glm::dvec3 step = glm::normalize(ray.direction);
  const auto [begin, end] = insideBox(low, high, ray.origin, step, ray.far_m);
  const auto at = [&](double t) { return ray.origin + t * step; };
  const auto above = [&](double t) -> std::optional<double> {
    const proto::LatticePosition p = frame.toLattice(at(t));
    const auto height_m = ground.heightAt({p.x, p.y});
    return height_m ? std::optional(p.height_m - *height_m) : std::nullopt;
  };
  std::optional<double> before;  // the last step, which was above the ground
  for (int i = 0; i <= kSteps && begin < end; ++i) {
    const double t = begin + (end - begin) * i / kSteps;
    const auto height_m = above(t);
    if (height_m && *height_m <= 0) {
      if (!before) return at(t);
      double outside = *before, inside = t;
      for (int k = 0; k < kHalvings; ++k) {
        const double middle = 0.5 * (outside + inside);
        (above(middle).value_or(0) > 0 ? outside : inside) = middle;
      }
      return at(inside);
    }
    before = height_m ? std::optional(t) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace foreland::client
