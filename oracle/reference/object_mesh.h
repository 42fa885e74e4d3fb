// The part of a keyframe mesh that is one object's, made from nothing: the union of the sections drawn at its two ends,
// with two positions per vertex and the same weights as the terrain's (mesh_builder.h). It is the reference that the
// mesh by change (client/mesh/objects/object_patcher.h) must equal. One owner; cost and memory are linear in the
// sections.
#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "client/mesh/objects/object_positions.h"
#include "client/mesh/patch/keyframe_mesh.h"
#include "client/mesh/weights/morphs.h"

namespace foreland::oracle {

// What of an object is drawn: the sections at the mesh's two ends, its nodes in transition, and where the ground has
// carried it to at either end (proto::GroundRise). A view.
struct ObjectSections {
  const proto::Section &from, &to, &newest;
  std::span<const client::Morph> morphs;
  std::array<glm::dvec3, 2> carried;
};

struct ObjectMesh {
  // By vertex, for the mesh's two ends: position in the scene's frame, metres, and packed normal.
  std::array<std::vector<glm::dvec3>, 2> position;
  std::array<std::vector<uint32_t>, 2> normal;
  // A vertex as one face of the base mesh has it.
  struct Corner {
    uint32_t vertex;
    glm::vec2 texture_coordinate;
  };
  std::vector<Corner> corners;
  std::vector<uint32_t> indices;  // of corners, three a triangle

  void appendTo(client::KeyframeMesh& mesh, uint32_t model) const;
};

ObjectMesh buildObjectMesh(const proto::ObjectSet& objects, const client::ObjectPositions& positions,
                           const ObjectSections& sections);

}  // namespace foreland::oracle
