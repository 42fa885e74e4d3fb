// The mesh between two keyframes: the union of the sections drawn at its two ends, with two positions per vertex. A
// frame is mix(from, to, weight) and nothing else (P, theorem 1; DESIGN section 2), so drawing costs no work per frame
// on the processor. The ends are the keyframes' sections, or with geomorphs as far as each node has come
// (client/blend.h): the positions follow from the nodes' weights and are linear in them, so both are drawn by the same
// mix. Plain data, built by Replica; one owner until published, then immutable.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "proto/message/message.h"

namespace foreland::client {

// Vertices with two positions each, and triangles.
struct BlendMesh {
  // One entry per vertex. xyz: metres from the origin, along the scene's axes; w: height above the zero surface,
  // metres (0 for objects).
  std::vector<glm::vec4> from_positions, to_positions;
  // Unit normals of the two ends' own surfaces, as signed bytes x, y, z, 0.
  std::vector<uint32_t> from_normals, to_normals;
  // The parameter that a vertex keeps whatever its position is: its lattice position; of objects its place in the
  // model's image (proto/topology/atlas_layout.h), so that a vertex on a base edge stands there once for each face.
  std::vector<glm::vec2> places;
  // Triangles, counter-clockwise seen from above or outside.
  std::vector<uint32_t> indices;

  size_t triangleCount() const { return indices.size() / 3; }
};

// The triangles of one object.
struct ObjectPart {
  uint32_t first_index, index_count;
  uint32_t model;
};

// The terrain, clipped to the data, and all objects.
struct KeyframeMesh : BlendMesh {
  // from.index == to.index: the first mesh, still, or one that goes on while the next keyframe is awaited.
  proto::KeyframeHeader from, to;
  glm::dvec3 origin{0};  // scene frame, metres; positions are relative to it
  BlendMesh objects;
  std::vector<ObjectPart> object_parts;

  uint32_t from_nodes = 0, to_nodes = 0;  // of the terrain, drawn at the two ends
};

}  // namespace foreland::client
