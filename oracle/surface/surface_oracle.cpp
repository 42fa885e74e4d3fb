#include "oracle/surface/surface_oracle.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "base/check.h"
#include "oracle/surface/oracle_eye.h"

namespace foreland::oracle {

namespace {

using Weights = std::array<int32_t, 2>;

int64_t twiceArea(const Weights& a, const Weights& b, const Weights& c) {
  return int64_t{b[0] - a[0]} * (c[1] - a[1]) - int64_t{b[1] - a[1]} * (c[0] - a[0]);
}

// Where a drawn triangle has the point of these weights, if it covers it.
std::optional<glm::dvec3> positionAt(const DrawnTriangle& t, const Weights& at) {
  const int64_t u = twiceArea(at, t.weights[1], t.weights[2]), v = twiceArea(t.weights[0], at, t.weights[2]),
                w = twiceArea(t.weights[0], t.weights[1], at);
  if (u < 0 || v < 0 || w < 0 || u + v + w == 0) return std::nullopt;
  return (static_cast<double>(u) * t.positions[0] + static_cast<double>(v) * t.positions[1] +
          static_cast<double>(w) * t.positions[2]) /
         static_cast<double>(u + v + w);
}

}  // namespace

SurfaceOracle::SurfaceOracle(SurfaceTruth truth) : truth_(std::move(truth)) {
  CHECK_EQ(truth_.points.size(), truth_.positions.size());
  by_point_.resize(truth_.points.size());
  std::iota(by_point_.begin(), by_point_.end(), 0u);
  std::sort(by_point_.begin(), by_point_.end(), [&](uint32_t a, uint32_t b) {
    const SurfacePoint &p = truth_.points[a], &q = truth_.points[b];
    return std::tie(p.face, p.weights) < std::tie(q.face, q.weights);
  });
  for (uint32_t i = 0; i < by_point_.size(); ++i)
    while (first_of_.size() <= truth_.points[by_point_[i]].face) first_of_.push_back(i);
  first_of_.push_back(static_cast<uint32_t>(by_point_.size()));
}

std::vector<std::optional<glm::dvec3>> SurfaceOracle::drawnPositions(std::span<const DrawnTriangle> drawn) const {
  std::vector<std::optional<glm::dvec3>> result(truth_.points.size());
  for (const DrawnTriangle& t : drawn) {
    if (t.face + 1 >= first_of_.size()) continue;
    const auto [low, high] = std::minmax({t.weights[0][0], t.weights[1][0], t.weights[2][0]});
    const auto begin = by_point_.begin() + first_of_[t.face], end = by_point_.begin() + first_of_[t.face + 1];
    const auto below = [&](uint32_t v, int32_t weight) { return truth_.points[v].weights[0] < weight; };
    for (auto v = std::lower_bound(begin, end, low, below); v != end && truth_.points[*v].weights[0] <= high; ++v)
      if (!result[*v]) result[*v] = positionAt(t, truth_.points[*v].weights);
  }
  return result;
}

std::vector<SurfaceOracle::Side> SurfaceOracle::sides(const glm::dvec3& eye) const {
  std::vector<uint8_t> seen(truth_.positions.size(), 0);  // 1: by a front face, 2: by a back face
  for (const auto& [a, b, c] : truth_.triangles) {
    const glm::dvec3& p = truth_.positions[a];
    const glm::dvec3 n = glm::cross(truth_.positions[b] - p, truth_.positions[c] - p);
    const uint8_t side = glm::dot(n, eye - p) > 0 ? 1 : 2;
    for (uint32_t v : {a, b, c}) seen[v] |= side;
  }
  std::vector<Side> result;
  for (uint8_t s : seen) {
    const Side away = truth_.is_closed ? Side::kAway : Side::kFront;
    result.push_back(s == 3 ? Side::kSilhouette : s == 1 ? Side::kFront : away);
  }
  return result;
}

SurfaceJudgement SurfaceOracle::judge(std::span<const DrawnTriangle> drawn, const proto::Pose& pose,
                                      const proto::Lens& lens, double near_m, const Counts& counts,
                                      const Stretch& stretch) const {
  const OracleEye eye(pose, lens, stretch);
  const auto positions = drawnPositions(drawn);
  const std::vector<Side> side = sides(pose.eye);
  SurfaceJudgement result;
  for (size_t v = 0; v < positions.size(); ++v) {
    const glm::dvec3& truth = truth_.positions[v];
    if (positions[v]) result.max_m = std::max(result.max_m, glm::length(*positions[v] - truth));
    if (side[v] == Side::kAway || eye.depth(truth) <= near_m || !eye.sees(eye.project(truth))) continue;
    if (!positions[v]) {
      ++result.uncovered;
      continue;
    }
    const double px = eye.depth(*positions[v]) > 0 ? glm::length(eye.project(*positions[v]) - eye.project(truth))
                                                   : std::numeric_limits<double>::infinity();
    if (counts && !counts(truth, px, side[v] == Side::kSilhouette)) continue;
    (side[v] == Side::kSilhouette ? result.silhouette : result.interior).add(px);
  }
  for (SurfaceErrors* errors : {&result.silhouette, &result.interior}) errors->finish();
  return result;
}

}  // namespace foreland::oracle
