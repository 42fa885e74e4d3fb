#include "oracle/surface/texel_oracle.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/check.h"
#include "oracle/surface/oracle_eye.h"

namespace foreland::oracle {

namespace {

// Of a triangle's area; texels that lie on an edge belong to both triangles, whatever the last digit says.
constexpr double kOnEdge = 1e-9;

double twiceArea(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Calls visit(texel, its barycentric weights) for each texel whose centre the triangle covers.
template <class Visit>
void forEachTexel(const TexturedTriangle& t, uint32_t width, uint32_t height, const Visit& visit) {
  const auto& [a, b, c] = t.texels;
  const double area = twiceArea(a, b, c);
  if (area == 0) return;
  const auto first = [](double low) { return static_cast<uint32_t>(std::max(0.0, std::floor(low - 0.5))); };
  const auto last = [](double high, uint32_t size) {
    return static_cast<uint32_t>(std::clamp(std::ceil(high + 0.5), 0.0, double(size)));
  };
  const uint32_t bottom = last(std::max({a.y, b.y, c.y}), height), right = last(std::max({a.x, b.x, c.x}), width);
  for (uint32_t y = first(std::min({a.y, b.y, c.y})); y < bottom; ++y)
    for (uint32_t x = first(std::min({a.x, b.x, c.x})); x < right; ++x) {
      const glm::dvec2 at(x + 0.5, y + 0.5);
      const glm::dvec3 weights = glm::dvec3(twiceArea(at, b, c), twiceArea(a, at, c), twiceArea(a, b, at)) / area;
      if (std::min({weights.x, weights.y, weights.z}) < -kOnEdge) continue;
      visit(y * width + x, weights.x * t.positions[0] + weights.y * t.positions[1] + weights.z * t.positions[2]);
    }
}

}  // namespace

TexelOracle::TexelOracle(std::vector<TexturedTriangle> truth, uint32_t width, uint32_t height, bool is_closed)
    : truth_(std::move(truth)), width_(width), height_(height), is_closed_(is_closed) {
  CHECK_LT(uint64_t{width} * height, uint64_t{1} << 32);
  positions_.resize(uint64_t{width} * height);
  for (uint32_t i = 0; i < truth_.size(); ++i)
    forEachTexel(truth_[i], width, height, [&](uint32_t texel, const glm::dvec3& place) {
      pairs_.push_back({texel, i});
      positions_[texel] = place;
    });
  std::sort(pairs_.begin(), pairs_.end());
  for (size_t i = 0; i < pairs_.size(); ++i) texels_ += i == 0 || pairs_[i][0] != pairs_[i - 1][0];
}

SurfaceJudgement TexelOracle::judge(std::span<const TexturedTriangle> drawn, const proto::Pose& pose,
                                    const proto::Lens& lens, double near_m) const {
  const OracleEye eye(pose, lens);
  std::vector<std::optional<glm::dvec3>> drawn_at(positions_.size());
  for (const TexturedTriangle& t : drawn)
    forEachTexel(t, width_, height_, [&](uint32_t texel, const glm::dvec3& place) { drawn_at[texel] = place; });
  std::vector<bool> faces_eye;
  for (const auto& [texels, p] : truth_)
    faces_eye.push_back(glm::dot(glm::cross(p[1] - p[0], p[2] - p[0]), pose.eye - p[0]) > 0);

  SurfaceJudgement result;
  for (size_t i = 0; i < pairs_.size();) {
    const uint32_t texel = pairs_[i][0];
    bool front = false, back = false;
    for (; i < pairs_.size() && pairs_[i][0] == texel; ++i) (faces_eye[pairs_[i][1]] ? front : back) = true;
    const glm::dvec3& truth = positions_[texel];
    const std::optional<glm::dvec3>& place = drawn_at[texel];
    if (place) result.max_m = std::max(result.max_m, glm::length(*place - truth));
    if ((!front && is_closed_) || eye.depth(truth) <= near_m || !eye.sees(eye.project(truth))) continue;
    if (!place) {
      ++result.uncovered;
      continue;
    }
    (front && back ? result.silhouette : result.interior)
        .add(eye.depth(*place) > 0 ? glm::length(eye.project(*place) - eye.project(truth))
                                   : std::numeric_limits<double>::infinity());
  }
  for (SurfaceErrors* errors : {&result.silhouette, &result.interior}) errors->finish();
  return result;
}

}  // namespace foreland::oracle
