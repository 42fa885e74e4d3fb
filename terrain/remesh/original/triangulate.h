// Triangulates a polygon in space without new vertices. Pure; any thread.
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

// Whether no three corners span an area, by the measure of triangulate().
bool isLine(std::span<const glm::dvec3> outline);

// size - 2 triangles as indices into the outline, with its orientation; empty if the polygon crosses itself or has no
// area. A triangle thinner than 1e-12 of its length counts as having no area. Quadrangles are split by the better
// diagonal, other polygons by clipping the best ear first. `may_join` tells whether a diagonal between two corners is
// allowed. Cost: cubic in the number of corners.
using MayJoin = std::function<bool(uint32_t, uint32_t)>;
std::vector<std::array<uint32_t, 3>> triangulate(std::span<const glm::dvec3> outline, const MayJoin& may_join);

}  // namespace foreland::terrain
