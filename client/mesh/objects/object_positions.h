// Where an object's vertices truly are at a mesh's two ends. Views; as long as what they refer to.
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <unordered_map>
#include <vector>

#include "client/mesh/patch/face_normal.h"
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

// Of a model's triangles, in its own frame.
FaceNormal objectFaceNormal(const proto::ObjectModel& model);

}  // namespace foreland::client
