// Where the colours of a surface stand in its one image: each base face has a triangle of (side + 1)(side + 2) / 2
// texels, two faces share a square cell, cells stand row by row. So texture coordinates follow from base face and
// weights, and from nothing else: a colour cannot slide over the surface, whatever mesh is drawn.
//
// Texel (i, j) of a face, i + j <= side, has its centre at the weights (side - i - j, i, j) / side: texels lie on the
// base edges, and faces that share an edge hold the same ones there. A node's texel is its lattice position: with
// `halvings` of quadrisection, the weights of proto::FacePoint times side / 2^halvings.
//
// Every pixel of a cell belongs to one of its two faces. Those beyond the triangles are the gutter: what lies on the
// other side of the edge (terrain/surface_store/fill_gutters.h). It is wide enough for bilinear filtering of the image
// and of two more, each half as large as the one before and the mean of 2 x 2 of its pixels: a viewer may let its
// graphics card make those, and no others. The image's sides can be halved that often without a remainder.
//
// Value type; portable; any thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>

namespace foreland::proto {

struct AtlasLayout {
  uint32_t faces = 0;    // of the base
  uint32_t side = 0;     // texel intervals along a base edge, a multiple of kUnit; 0: there is no image
  uint32_t columns = 0;  // cells in a row

  static constexpr uint32_t kMaxPixels = 1u << 14;  // along either side of the image
  static constexpr uint32_t kHalvings = 2;
  static constexpr uint32_t kUnit = 1u << kHalvings;

  // About square. The side is rounded up to a multiple of kUnit.
  static AtlasLayout of(uint32_t faces, uint32_t side) {
    const uint32_t cells = (faces + 1) / 2;
    return {faces, (side + kUnit - 1) / kUnit * kUnit,
            static_cast<uint32_t>(std::ceil(std::sqrt(static_cast<double>(cells))))};
  }

  // Filtering the smallest image at a point of a triangle reads pixels up to kGutter columns or rows before it, fewer
  // behind it, and up to side + 10 in i + j.
  static constexpr int32_t kGutter = kUnit;
  uint32_t cellSize() const { return side + 20; }
  uint32_t rows() const { return columns == 0 ? 0 : ((faces + 1) / 2 + columns - 1) / columns; }
  uint32_t width() const { return side == 0 ? 0 : columns * cellSize(); }
  uint32_t height() const { return side == 0 ? 0 : rows() * cellSize(); }

  // The pixel of texel (i, j), from the image's upper left corner. The gutter's have numbers below 0 and sums above
  // the side.
  glm::ivec2 pixel(uint32_t face, int32_t i, int32_t j) const {
    const uint32_t cell = face / 2;
    const glm::ivec2 corner(cell % columns * cellSize(), cell / columns * cellSize()), at(kGutter + i, kGutter + j);
    return corner + (face % 2 == 0 ? at : glm::ivec2(static_cast<int32_t>(cellSize()) - 1) - at);
  }

  // All texels that are the face's, its gutter's included: i of columnsOf(face, j) for j of rowsOf(face).
  struct Span {
    int32_t begin, end;
  };
  Span rowsOf(uint32_t face) const { return {-kGutter, size(face) - kGutter}; }
  Span columnsOf(uint32_t face, int32_t j) const { return {-kGutter, size(face) - j - 2 * kGutter}; }

  // Whose pixel it is; none in what is left of the last row of cells. The pixel is one of the image.
  std::optional<uint32_t> faceAt(const glm::uvec2& pixel) const {
    const uint32_t size = cellSize(), cell = pixel.y / size * columns + pixel.x / size;
    const uint32_t face = 2 * cell + (pixel.x % size + pixel.y % size >= size ? 1 : 0);
    return face < faces ? std::optional(face) : std::nullopt;
  }

  // Texture coordinates, (0, 0) at the image's upper left corner and (1, 1) at its lower right one. `weights` are of
  // the face's corners.
  glm::dvec2 coordinates(uint32_t face, const glm::dvec3& weights) const {
    const glm::dvec2 origin(pixel(face, 0, 0)), along(weights.y * side, weights.z * side);
    const glm::dvec2 at = origin + 0.5 + (face % 2 == 0 ? along : -along);
    return at / glm::dvec2(width(), height());
  }
  bool operator==(const AtlasLayout&) const = default;

 private:
  // Pixels in the first row of the face's half of its cell. The diagonal between the halves is the even face's.
  int32_t size(uint32_t face) const { return static_cast<int32_t>(cellSize()) - (face % 2 == 0 ? 0 : 1); }
};

}  // namespace foreland::proto
