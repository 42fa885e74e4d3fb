// Tiles of what is laid over the terrain: relief (heights at full resolution, which ground is shaded by) and imagery.
// A layer is a raster of texels over the data and its levels: a texel of level l + 1 is the mean of 2 x 2 of level l.
// Level 0 is the finest; the last level is one tile. Columns run with the lattice's x and rows with its y, so row 0 is
// the southern one, in images too.
//
// A tile is 256 x 256 texels: 248 of its own and a gutter of 4 on every side, so that it can be filtered alone. The
// half-size image of a tile is, gutters included, a quarter of its parent. Beyond the raster texels repeat its border.
//
// On a globe a layer is six rasters, one for each face of the cube (proto/topology/cube.h), and each has its own tiles
// up to its own coarsest one. A tile's x counts on over the faces: face f begins at f times the tiles of a face,
// rounded up to a power of two. Gutters show what lies on the faces beyond.
//
// Values and pure functions; any thread; portable to WebAssembly.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>

#include "base/result.h"

namespace foreland::proto {

inline constexpr uint32_t kTileSide = 256;  // texels of a tile's image along each side
inline constexpr uint32_t kTileGutter = 4;  // of these, beyond the tile on each side
inline constexpr uint32_t kTilePayload = kTileSide - 2 * kTileGutter;
inline constexpr uint32_t kMaxTileLayers = 2;
inline constexpr uint32_t kMaxTileLevels = 20;
inline constexpr uint32_t kMaxLayerSide = 1u << 26;  // texels
inline constexpr double kMaxGlobeStep_m = 8;         // of heights, but where the finest have larger ones
inline constexpr uint32_t kMaxTileBytes = 1u << 20;  // of one tile, coded

enum class TileContent : uint8_t { kRelief = 0, kImagery = 1 };
// How the bytes of a tile are coded: by relief_codec.h, or as a file of an image format.
enum class TileCoding : uint8_t { kHeights = 0, kWebP = 1 };

// `layer` counts from 0 in the order of the scene's layers, of which no two have the same content.
struct TileId {
  uint8_t layer = 0;
  uint8_t level = 0;
  uint32_t x = 0, y = 0;

  TileId parent() const { return {layer, static_cast<uint8_t>(level + 1), x / 2, y / 2}; }
  // One of four, of which the layer need not have all; not of a tile of level 0. South-west, south-east, north-west,
  // north-east.
  TileId child(uint32_t k) const { return {layer, static_cast<uint8_t>(level - 1), 2 * x + k % 2, 2 * y + k / 2}; }
  // One number for each tile.
  uint64_t key() const { return uint64_t{layer} << 56 | uint64_t{level} << 48 | uint64_t{y} << 24 | x; }
  static TileId of(uint64_t key) {
    return {static_cast<uint8_t>(key >> 56), static_cast<uint8_t>(key >> 48), static_cast<uint32_t>(key & 0xffffff),
            static_cast<uint32_t>(key >> 24 & 0xffffff)};
  }
  bool operator==(const TileId&) const = default;
};

// What selects a tile: the heights of the ground within it, and the directions of its normals.
struct TileBounds {
  float lowest_m = 0, highest_m = 0;  // above the zero surface
  // A cone of normals: its axis in the scene's axes (unit length is 127), and the largest angle from it in units of
  // pi / 510, rounded up, so that 255 is pi / 2. An axis of zeros: any direction.
  int8_t axis[3]{0, 0, 127};
  uint8_t half_angle = 0;
  bool operator==(const TileBounds&) const = default;
};

// A rectangle of the lattice.
struct LatticeBox {
  glm::dvec2 low, high;
};

struct TileLayer {
  TileContent content = TileContent::kRelief;
  TileCoding coding = TileCoding::kHeights;
  uint32_t width = 0, height = 0;  // texels of level 0; on a globe of each face
  glm::dvec2 origin{0, 0};         // lattice position of the south-western corner of the first texel
  double texel = 1;                // sample intervals that a texel of level 0 spans, along x and along y
  double step_m = 0;               // relief: heights are multiples of it; see stepAt()
  std::string attribution;         // to be shown where the layer is; may be empty
  // On a globe lattice steps along each side of a face, else 0. It follows from the scene, and is neither stored nor
  // sent.
  uint32_t face_steps = 0;

  bool isGlobe() const { return face_steps > 0; }
  uint32_t faces() const { return isGlobe() ? 6 : 1; }
  // On which face a tile is, which column of the face's tiles it is in, and its x by these.
  uint32_t faceOf(const TileId& t) const { return t.x >> faceBits(t.level); }
  uint32_t columnOf(const TileId& t) const { return t.x & ((1u << faceBits(t.level)) - 1); }
  uint32_t xOf(uint32_t level, uint32_t face, uint32_t column) const { return face << faceBits(level) | column; }
  // Of the tiles of a level.
  uint32_t faceBits(uint32_t level) const { return levels() - 1 - level; }
  uint32_t widthAt(uint32_t level) const { return atLevel(width, level); }
  uint32_t heightAt(uint32_t level) const { return atLevel(height, level); }
  // Of the raster; on a globe of one face.
  uint32_t tilesX(uint32_t level) const { return tilesOf(widthAt(level)); }
  uint32_t tilesY(uint32_t level) const { return tilesOf(heightAt(level)); }
  uint32_t levels() const { return std::bit_width(tilesOf(std::max(width, height)) - 1) + 1u; }
  bool isCoarsest(const TileId& t) const { return t.level + 1u == levels(); }
  bool has(const TileId& t) const {
    return t.level < levels() && faceOf(t) < faces() && columnOf(t) < tilesX(t.level) && t.y < tilesY(t.level);
  }
  double texelAt(uint32_t level) const { return texel * static_cast<double>(uint64_t{1} << level); }
  // Relief: heights of a level are multiples of this; twice as much as on the finer level, but on a globe, of which
  // texels of the coarsest level are as large as countries, not more than kMaxGlobeStep_m.
  double stepAt(uint32_t level) const {
    const double doubled = step_m * static_cast<double>(uint64_t{1} << level);
    return isGlobe() ? std::min(doubled, std::max(step_m, kMaxGlobeStep_m)) : doubled;
  }
  // The lattice position of the south-western corner of a level's texel, and of a tile's first own texel.
  glm::dvec2 cornerOf(const TileId& t) const {
    return originOf(t) + glm::dvec2(columnOf(t), t.y) * (kTilePayload * texelAt(t.level));
  }
  // Where a tile lies, without what is beyond the raster.
  LatticeBox boxOf(const TileId& t) const {
    const glm::dvec2 low = cornerOf(t), end = originOf(t) + glm::dvec2(width, height) * texel;
    const double side = kTilePayload * texelAt(t.level);
    return {low, {std::min(low.x + side, end.x), std::min(low.y + side, end.y)}};
  }
  // Known content and coding that go together; finite numbers, sizes within the limits above; on a globe texels that
  // fill the faces, those of coarser levels, too.
  Status validate() const;
  bool operator==(const TileLayer&) const = default;

 private:
  // Of the first texel on a tile's face.
  glm::dvec2 originOf(const TileId& t) const { return {origin.x + 1.0 * faceOf(t) * face_steps, origin.y}; }
  static uint32_t atLevel(uint32_t texels, uint32_t level) {
    return static_cast<uint32_t>((texels + (uint64_t{1} << level) - 1) >> level);
  }
  static uint32_t tilesOf(uint32_t texels) { return (texels + kTilePayload - 1) / kTilePayload; }
};

}  // namespace foreland::proto
