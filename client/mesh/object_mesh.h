// The part of a keyframe mesh that is one object's: the union of the sections drawn at its two ends, with two positions
// per vertex and the same weights as the terrain's (mesh_builder.h). One owner; cost and memory are linear in the
// sections.
#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <unordered_map>
#include <vector>

#include "client/mesh/face_normal.h"
#include "client/mesh/keyframe_mesh.h"
#include "client/mesh/morphs.h"
#include "proto/codec/object_stream.h"

namespace foreland::client {

// What is kept of a removed node that may still be drawn: quanta of its model.
struct RemovedNode {
  glm::ivec3 position;
  std::vector<glm::ivec3> moves;  // in each pose but the first
};

// By pose but for the first (proto::PoseBlend), at a mesh's two ends; empty if the object is still.
using PoseWeights = std::array<std::vector<double>, 2>;

// Where an object's vertices truly are at a mesh's two ends: those of the newest section, from the stream, and removed
// nodes that may still be drawn. A view.
struct ObjectPositions {
  const proto::ObjectSet& objects;
  const proto::ObjectStream& stream;
  size_t object;
  const std::unordered_map<proto::Slot, RemovedNode>& removed;
  const PoseWeights& weights;

  // Object's frame, metres.
  glm::dvec3 at(proto::NodeId v, size_t end) const;
};

// What of an object is drawn: the sections at the mesh's two ends, its nodes in transition, and where the ground has
// carried it to at either end (proto::GroundRise). A view.
struct ObjectSections {
  const proto::Section &from, &to, &newest;
  std::span<const Morph> morphs;
  std::array<glm::dvec3, 2> carried;
};

// Of a model's triangles, in its own frame.
FaceNormal objectFaceNormal(const proto::ObjectModel& model);

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

  void appendTo(KeyframeMesh& mesh, uint32_t model) const;
};

ObjectMesh buildObjectMesh(const proto::ObjectSet& objects, const ObjectPositions& positions,
                           const ObjectSections& sections);

}  // namespace foreland::client
