// Draws triangles into a depth buffer on one thread: the work that drawing a frame takes without a graphics card, to
// compare refinement with. Vertices are projected once each, triangles filled at pixel centres, front faces only. One
// owner; no allocation once grown.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "proto/space/pose.h"

namespace foreland::lab {

class DepthDrawing {
 public:
  explicit DepthDrawing(const proto::Lens& lens);

  // Returns how many pixels are covered. Triangles that reach behind the eye are left out.
  size_t draw(std::span<const glm::dvec3> positions, std::span<const std::array<uint32_t, 3>> triangles,
              const proto::Pose& pose);

 private:
  struct Screen {
    float x, y, inverse_depth;  // pixels from the lower left; 0 behind the eye
  };
  void fill(const Screen& a, const Screen& b, const Screen& c);

  proto::Lens lens_;
  std::vector<Screen> screen_;
  std::vector<float> nearness_;  // 1 / depth, row by row
};

}  // namespace foreland::lab
