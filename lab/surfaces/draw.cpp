#include "lab/surfaces/draw.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace foreland::lab {

DepthDrawing::DepthDrawing(const proto::Lens& lens)
    : lens_(lens), nearness_(static_cast<size_t>(lens.width_px) * lens.height_px) {}

size_t DepthDrawing::draw(std::span<const glm::dvec3> positions, std::span<const std::array<uint32_t, 3>> triangles,
                          const proto::Pose& pose) {
  std::fill(nearness_.begin(), nearness_.end(), 0.0f);
  const glm::dvec3 right = pose.right(), up = pose.up(), forward = pose.forward();
  const double focal = lens_.focalPx(), middle_x = 0.5 * lens_.width_px, middle_y = 0.5 * lens_.height_px;
  screen_.clear();
  for (const glm::dvec3& p : positions) {
    const glm::dvec3 from_eye = p - pose.eye;
    const double depth = glm::dot(from_eye, forward), inverse = depth > 1e-6 ? 1 / depth : 0;
    screen_.push_back({static_cast<float>(middle_x + focal * glm::dot(from_eye, right) * inverse),
                       static_cast<float>(middle_y + focal * glm::dot(from_eye, up) * inverse),
                       static_cast<float>(inverse)});
  }
  for (const auto& [a, b, c] : triangles) fill(screen_[a], screen_[b], screen_[c]);
  return static_cast<size_t>(std::count_if(nearness_.begin(), nearness_.end(), [](float n) { return n > 0; }));
}

void DepthDrawing::fill(const Screen& a, const Screen& b, const Screen& c) {
  const float area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  if (!(area > 0) || a.inverse_depth == 0 || b.inverse_depth == 0 || c.inverse_depth == 0) return;
  const auto clampTo = [](float v, uint32_t size) {
    return static_cast<int32_t>(std::clamp(v, 0.0f, static_cast<float>(size)));
  };
  const int32_t left = clampTo(std::min({a.x, b.x, c.x}), lens_.width_px);
  const int32_t end_x = clampTo(std::max({a.x, b.x, c.x}) + 1, lens_.width_px);
  const int32_t low = clampTo(std::min({a.y, b.y, c.y}), lens_.height_px);
  const int32_t end_y = clampTo(std::max({a.y, b.y, c.y}) + 1, lens_.height_px);
  const float inverse_area = 1 / area;
  for (int32_t y = low; y < end_y; ++y) {
    float* row = nearness_.data() + static_cast<size_t>(y) * lens_.width_px;
    const float py = static_cast<float>(y) + 0.5f;
    for (int32_t x = left; x < end_x; ++x) {
      const float px = static_cast<float>(x) + 0.5f;
      const float u = ((c.x - b.x) * (py - b.y) - (c.y - b.y) * (px - b.x)) * inverse_area;
      const float v = ((a.x - c.x) * (py - c.y) - (a.y - c.y) * (px - c.x)) * inverse_area;
      const float w = 1 - u - v;
      if (u < 0 || v < 0 || w < 0) continue;
      row[x] = std::max(row[x], u * a.inverse_depth + v * b.inverse_depth + w * c.inverse_depth);
    }
  }
}

}  // namespace foreland::lab
