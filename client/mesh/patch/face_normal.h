// Normals of triangles as vectors whose sums are exact: rounded to multiples of one quantum, so few bits that doubles
// add them without rounding. A vertex's sum then depends neither on the order of its triangles nor on how often
// triangles were added and subtracted again, and a mesh that changes little by little keeps the bits of one made anew.
//
// The quantum is 2^-48 of the largest product that triangles of the surface can have, hence finer than 1/16000 of the
// smallest triangle of any grid. Surfaces that are 16 times larger than stated still add exactly. Of a globe's mesh the
// smallest triangles may be 2^-40 of the largest, so all count alike there, whatever their area. Value; any thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "proto/refine/metric/terrain_domain.h"

namespace foreland::client {

class FaceNormal {
 public:
  // For triangles whose edges are no longer than `longest_edge` (metres, or an object's own units).
  explicit FaceNormal(double longest_edge)
      : rounder_(std::exp2(std::ceil(2 * std::log2(std::max(longest_edge, 1e-100))) - 48 + 51) * 3) {}

  // Whose result is of length 1, or 0.
  static FaceNormal evenly() {
    FaceNormal normal(1);
    normal.is_even_ = true;
    return normal;
  }

  // Twice the triangle's area, along its normal.
  glm::dvec3 operator()(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) const {
    glm::dvec3 normal = glm::cross(b - a, c - a);
    if (is_even_) normal /= std::max(glm::length(normal), 1e-100);
    // What is added has the quantum as its last bit, so adding it rounds to multiples of that.
    return (normal + rounder_) - rounder_;
  }

 private:
  double rounder_;  // 1.5 * 2^52 quanta
  bool is_even_ = false;
};

// Of a terrain: edges span at most a root square's side, and 20 km of height.
inline FaceNormal terrainFaceNormal(const proto::TerrainDomain& domain) {
  constexpr double kHeight_m = 20'000;
  const proto::Frame& frame = domain.frame.transform().frame();
  if (frame.kind == proto::FrameKind::kGlobe) return FaceNormal::evenly();
  const double radians = std::max(frame.latitude_step_rad, frame.longitude_step_rad);
  const double step_m =
      domain.isPlanar() ? glm::length(frame.axis_x_m) + glm::length(frame.axis_y_m) : 2 * radians * frame.semi_major_m;
  return FaceNormal(step_m * domain.grid.rootSize() + kHeight_m);
}

}  // namespace foreland::client
