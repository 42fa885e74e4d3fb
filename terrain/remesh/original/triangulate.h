// Cuts a polygon in space into triangles by its own corners. Pure; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace foreland::terrain {

// Twice the vector area of a polygon (Newell): its direction is the polygon's normal.
glm::dvec3 vectorArea(std::span<const glm::dvec3> outline);

// 1 for an equilateral triangle, 0 for one without area: 4 sqrt(3) area / sum of squared sides.
double triangleQuality(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);

// Triangles as indices into the outline, turned as it is; size - 2 of them. Empty if there is no way to cut it: it
// crosses itself or has no area. A triangle thinner than 1e-12 of its length counts as having no area. Quadrangles by
// the better diagonal, others by clipping the best ear first. `may_cut` says whether two corners may be joined. Cost:
// cubic in the corners.
using MayCut = std::function<bool(uint32_t, uint32_t)>;
std::vector<std::array<uint32_t, 3>> triangulate(std::span<const glm::dvec3> outline, const MayCut& may_cut);

}  // namespace foreland::terrain
