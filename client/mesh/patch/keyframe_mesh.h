// The mesh between two keyframes: the union of the sections drawn at its two ends, with two positions per vertex. A
// frame is mix(from, to, weight) and nothing else (P, theorem 1; THEORY section 2), so the processor does no work per
// frame. The ends are the keyframes' sections, or with geomorphs (client/mesh/weights/blend.h) as far as each node has
// morphed: positions are linear in the nodes' weights, so the same mix draws both. Where more than two keyframes are
// blended, a vertex goes from end to end on a curve, of which the mesh has how far it bends. Plain data, built by
// Replica; one owner until it is published, immutable afterwards.
#pragma once

#include <array>
#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "proto/message/message.h"
#include "proto/topology/atlas_layout.h"

namespace foreland::client {

// The keyframes before `from` that a mesh blends as well, the newest first, and how much older what it shows is than
// its last two keyframes.
struct EarlierKeyframes {
  uint32_t count = 0;
  std::array<proto::KeyframeHeader, proto::kMaxOrder - 1> headers{};
  Duration from_age{}, to_age{};
};

// Vertices with two positions each, and triangles.
struct BlendMesh {
  // One entry per vertex. xyz: metres from the origin, along the scene's axes; w: height above the zero surface,
  // metres (0 for objects).
  std::vector<glm::vec4> from_positions, to_positions;
  // How far the ground has moved upwards since the first epoch, metres. Empty if it does not move, and for objects.
  std::vector<float> from_moved, to_moved;
  // How vertices leave the straight lines between their ends, metres: at weight w a vertex is at
  //   mix(from, to, w) + w (1 - w) mix(from_bend, to_bend, w),
  // which is any cubic curve: with Bezier's controls a and b these are 3 a - 2 from - to and 3 b - from - 2 to. Of
  // positions alone, not of their heights. Empty where two keyframes are blended, and for objects, which always are.
  std::vector<glm::vec3> from_bends, to_bends;
  // Unit normals of the surface at either end, packed by pack_normal.h.
  std::vector<uint32_t> from_normals, to_normals;
  // What identifies a vertex on the surface, whatever its position. Terrain: the lattice position. Objects: the texture
  // coordinate by parameterLayout, so a vertex on a base edge is stored once for each face that it belongs to.
  std::vector<glm::vec2> parameters;
  // Triangles, counter-clockwise seen from above or outside.
  std::vector<uint32_t> indices;

  size_t triangleCount() const { return indices.size() / 3; }
  // Where a vertex is drawn, and its height, at a weight from 0 to 1.
  glm::dvec4 at(size_t vertex, double weight) const {
    const glm::dvec4 straight = glm::mix(glm::dvec4(from_positions[vertex]), glm::dvec4(to_positions[vertex]), weight);
    if (from_bends.empty()) return straight;
    const glm::dvec3 bend = glm::mix(glm::dvec3(from_bends[vertex]), glm::dvec3(to_bends[vertex]), weight);
    return straight + glm::dvec4(weight * (1 - weight) * bend, 0);
  }
};

// How the texture coordinates of a model's vertices follow from base face and weights: by the layout of its image, or
// by one of 64 texels a base edge if it has none, so that coordinates identify vertices in any case.
inline proto::AtlasLayout parameterLayout(uint32_t faces, uint32_t atlas_side) {
  constexpr uint32_t kWithoutImage = 64;
  return proto::AtlasLayout::of(faces, atlas_side > 0 ? atlas_side : kWithoutImage);
}

// The triangles of one object. Those of no part have three times the same corner.
struct ObjectPart {
  uint32_t first_index, index_count;
  uint32_t model;
};

// The terrain, clipped to the data, and all objects.
struct KeyframeMesh : BlendMesh {
  // from.index == to.index for the first mesh, which does not move, and for one that extends transitions while the next
  // keyframe is late.
  proto::KeyframeHeader from, to;
  EarlierKeyframes earlier;
  glm::dvec3 origin{0};  // scene frame, metres; positions are relative to it
  BlendMesh objects;
  std::vector<ObjectPart> object_parts;

  uint32_t from_nodes = 0, to_nodes = 0;  // terrain nodes drawn at either end

  // That are drawn: of the terrain, and of the objects' parts.
  size_t drawnTriangles() const {
    size_t count = indices.size();
    for (const ObjectPart& part : object_parts) count += part.index_count;
    return count / 3;
  }
};

}  // namespace foreland::client
