// The meshes behind a ray caster: where the corners of the triangle that Embree found stand exactly. Immutable; any
// thread.
#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>

#include "base/result.h"
#include "terrain/render/embree_scene.h"
#include "terrain/render/ray_caster.h"

namespace foreland::terrain {

struct TriangleCorner {
  glm::dvec3 position{0};  // scene frame, metres
  glm::dvec2 parameter{0};
  double height_m = 0;
};

class TriangleSource {
 public:
  virtual ~TriangleSource() = default;
  // In the order of the hit's weights (1 - u - v, u, v).
  virtual std::array<TriangleCorner, 3> corners(const EmbreeHit& hit) const = 0;
  virtual int32_t object(const EmbreeHit& hit) const = 0;
};

struct RayCaster::Impl {
  EmbreeScene embree;
  glm::dvec3 origin{0};  // of Embree's floats, in the scene frame
  std::unique_ptr<const TriangleSource> triangles;
};

}  // namespace foreland::terrain
