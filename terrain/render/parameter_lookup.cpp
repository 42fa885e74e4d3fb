#include "terrain/render/parameter_lookup.h"

#include <cmath>

namespace foreland::terrain {

namespace {

float heightOf(int32_t object) { return static_cast<float>(-1 - object); }

std::vector<glm::vec3> flatten(const DrawnSurface::Triangles& part) {
  std::vector<glm::vec3> flat;
  flat.reserve(part.parameters.size());
  for (const glm::vec2& p : part.parameters) flat.emplace_back(p, 0.0f);
  return flat;
}

double cross(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

}  // namespace

Result<ParameterLookup> ParameterLookup::of(DrawnSurface surface) {
  ParameterLookup lookup;
  lookup.flat_.addTriangles(flatten(surface.terrain), surface.terrain.indices);
  // No vertex is of two objects.
  std::vector<glm::vec3> flat = flatten(surface.objects);
  for (size_t object = 0; object < surface.object_begin.size(); ++object) {
    const size_t end = object + 1 < surface.object_begin.size() ? surface.object_begin[object + 1]
                                                                : surface.objects.indices.size() / 3;
    for (size_t i = 3 * size_t{surface.object_begin[object]}; i < 3 * end; ++i)
      flat[surface.objects.indices[i]].z = heightOf(static_cast<int32_t>(object));
  }
  lookup.flat_.addTriangles(flat, surface.objects.indices);
  if (Status s = lookup.flat_.commit(); !s.ok()) return s.error();
  lookup.surface_ = std::move(surface);
  return lookup;
}

std::optional<glm::dvec3> ParameterLookup::find(const DrawnSurface::Triangles& part, const glm::dvec2& parameter,
                                                float height) const {
  const auto hit = flat_.cast({glm::vec2(parameter), height + 0.5f}, {0, 0, -1}, 0.0f, 1.0f);
  if (!hit) return std::nullopt;
  const uint32_t* v = &part.indices[3 * size_t{hit->primitive}];
  const glm::dvec2 a(part.parameters[v[0]]), u = glm::dvec2(part.parameters[v[1]]) - a,
                                             w = glm::dvec2(part.parameters[v[2]]) - a, p = parameter - a;
  const double at_u = cross(p, w) / cross(u, w), at_w = cross(u, p) / cross(u, w);
  if (!std::isfinite(at_u + at_w)) return std::nullopt;
  return surface_.origin + (1 - at_u - at_w) * glm::dvec3(part.positions[v[0]]) +
         at_u * glm::dvec3(part.positions[v[1]]) + at_w * glm::dvec3(part.positions[v[2]]);
}

std::optional<glm::dvec3> ParameterLookup::terrainAt(const glm::dvec2& lattice) const {
  return find(surface_.terrain, lattice, heightOf(RayHit::kTerrain));
}

std::optional<glm::dvec3> ParameterLookup::objectAt(int32_t object, const glm::dvec2& texture_coordinates) const {
  return find(surface_.objects, texture_coordinates, heightOf(object));
}

}  // namespace foreland::terrain
