// The ground of a scene at full resolution, as full_scene.cpp puts it together with objects. Immutable; any thread.
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <memory>

#include "terrain/render/embree_scene.h"
#include "terrain/render/triangle_source.h"

namespace foreland::terrain {

class FullGround {
 public:
  virtual ~FullGround() = default;
  // Whether it is more than is cast rays at.
  virtual bool isTooLarge() const = 0;
  // Adds one geometry, relative to an origin.
  virtual void addTo(EmbreeScene& embree, const glm::dvec3& origin) const = 0;
  // In the order of the hit's weights.
  virtual std::array<TriangleCorner, 3> corners(const EmbreeHit& hit) const = 0;
};

// Of a globe, without what the body hides from a place.
std::unique_ptr<FullGround> fullGlobe(std::shared_ptr<const Scene> scene, const glm::dvec3& eye);

}  // namespace foreland::terrain
