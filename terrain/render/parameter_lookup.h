// Where a drawn mesh puts a point of the surface: its position at a parameter. Surfaces correspond by parameter, never
// by nearest point, so that a texture which slid would be seen (THEORY section 3). The meshes are laid out flat by
// their parameters, the terrain at height 0 and object i at height -1 - i, and a vertical ray finds the triangle there.
//
// Precision: positions are computed in doubles on the triangle found. It is chosen in floats, so that within 2^-23 of
// the coordinate (a 2000th of a sample at lattice position 4096) beside an edge it may be the neighbour, whose plane is
// continued. Immutable; any thread. About 100 bytes a triangle; a look-up takes about half a microsecond.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>

#include "terrain/render/embree_scene.h"
#include "terrain/render/ray_caster.h"

namespace foreland::terrain {

class ParameterLookup {
 public:
  // An Error if memory does not suffice.
  static Result<ParameterLookup> of(DrawnSurface surface);

  // Scene frame, metres. Nothing where no triangle is: beyond the data, or on models without an image.
  std::optional<glm::dvec3> terrainAt(const glm::dvec2& lattice) const;
  std::optional<glm::dvec3> objectAt(int32_t object, const glm::dvec2& texture_coordinates) const;
  // The counterpart of a point on another mesh of the same scene.
  std::optional<glm::dvec3> at(const RayHit& hit) const {
    return hit.object == RayHit::kTerrain ? terrainAt(hit.parameter) : objectAt(hit.object, hit.parameter);
  }

 private:
  ParameterLookup() = default;
  std::optional<glm::dvec3> find(const DrawnSurface::Triangles& part, const glm::dvec2& parameter, float height) const;

  DrawnSurface surface_;
  EmbreeScene flat_;
};

}  // namespace foreland::terrain
