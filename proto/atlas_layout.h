// Where the colours of a surface stand in its one image: each base face has a triangle of (side + 1)(side + 2) / 2
// texels, two faces share a cell, cells stand row by row. So texture coordinates follow from base face and weights, and
// from nothing else: a colour cannot slide over the surface, whatever mesh is drawn.
//
// Texel (i, j) of a face, i + j <= side, has its centre at the weights (side - i - j, i, j) / side: texels lie on the
// base edges, and faces that share an edge hold the same ones there. Around each triangle there is a gutter of one
// texel, two beyond its slanting side: along that one bilinear filtering takes half of what it reads from beyond, so
// the gutter holds what continues the triangle linearly. So both faces of an edge show the same along it, unless that
// were darker than black or brighter than full.
//
// Value type; portable; any thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace foreland::proto {

struct AtlasLayout {
  uint32_t faces = 0;    // of the base
  uint32_t side = 0;     // texel intervals along a base edge; 0: there is no image
  uint32_t columns = 0;  // cells in a row

  static constexpr uint32_t kMaxPixels = 1u << 14;  // along either side of the image

  // About square.
  static AtlasLayout of(uint32_t faces, uint32_t side) {
    const uint32_t cells = (faces + 1) / 2;
    return {faces, side, static_cast<uint32_t>(std::ceil(std::sqrt(static_cast<double>(cells))))};
  }

  uint32_t cellWidth() const { return side + 5; }
  uint32_t cellHeight() const { return side + 4; }
  uint32_t rows() const { return columns == 0 ? 0 : ((faces + 1) / 2 + columns - 1) / columns; }
  uint32_t width() const { return side == 0 ? 0 : columns * cellWidth(); }
  uint32_t height() const { return side == 0 ? 0 : rows() * cellHeight(); }

  // The pixel of texel (i, j), from the image's upper left corner. From -1 to side + 2: the gutter has pixels too.
  glm::ivec2 pixel(uint32_t face, int32_t i, int32_t j) const {
    const uint32_t cell = face / 2;
    const glm::ivec2 corner(cell % columns * cellWidth(), cell / columns * cellHeight());
    const auto w = static_cast<int32_t>(cellWidth()), h = static_cast<int32_t>(cellHeight());
    return corner + (face % 2 == 0 ? glm::ivec2(1 + i, 1 + j) : glm::ivec2(w - 2 - i, h - 2 - j));
  }

  // Texture coordinates, (0, 0) at the image's upper left corner and (1, 1) at its lower right one. `weights` are of
  // the face's corners.
  glm::dvec2 coordinates(uint32_t face, const glm::dvec3& weights) const {
    const glm::dvec2 origin(pixel(face, 0, 0)), along(weights.y * side, weights.z * side);
    const glm::dvec2 at = origin + 0.5 + (face % 2 == 0 ? along : -along);
    return at / glm::dvec2(width(), height());
  }
  bool operator==(const AtlasLayout&) const = default;
};

}  // namespace foreland::proto
