// The surface that a mesh between two keyframes shows: the position of each lattice sample. Brute force, from the
// triangles' lattice positions alone.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

#include "client/mesh/patch/keyframe_mesh.h"
#include "proto/topology/grid.h"

namespace foreland::test {

class LatticeSurface {
 public:
  LatticeSurface(const client::KeyframeMesh& mesh, double weight, const proto::GridShape& shape)
      : width_(shape.samples_x), at_(size_t{shape.samples_x} * shape.samples_y, glm::dvec3(kNowhere)) {
    for (size_t i = 0; i < mesh.indices.size(); i += 3) draw(mesh, weight, &mesh.indices[i]);
  }

  // Scene frame, metres; not a number where there is no triangle.
  const glm::dvec3& at(uint32_t x, uint32_t y) const { return at_[size_t{y} * width_ + x]; }

 private:
  static constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();

  static double across(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

  void draw(const client::KeyframeMesh& mesh, double weight, const uint32_t* corners) {
    glm::dvec2 place[3];
    glm::dvec3 at[3];
    for (size_t k = 0; k < 3; ++k) {
      place[k] = mesh.parameters[corners[k]];
      at[k] = mesh.origin + glm::dvec3(mesh.at(corners[k], weight));
    }
    const glm::dvec2 low = glm::ceil(glm::min(place[0], glm::min(place[1], place[2])));
    const glm::dvec2 high = glm::floor(glm::max(place[0], glm::max(place[1], place[2])));
    const double area = across(place[1] - place[0], place[2] - place[0]);
    for (double y = low.y; y <= high.y; ++y)
      for (double x = low.x; x <= high.x; ++x) {
        const glm::dvec2 p(x, y);
        const double u = across(p - place[0], place[2] - place[0]) / area;
        const double v = across(place[1] - place[0], p - place[0]) / area;
        if (u < 0 || v < 0 || u + v > 1) continue;
        at_[static_cast<size_t>(y) * width_ + static_cast<size_t>(x)] =
            at[0] + u * (at[1] - at[0]) + v * (at[2] - at[0]);
      }
  }

  size_t width_;
  std::vector<glm::dvec3> at_;
};

}  // namespace foreland::test
