// The client's copy of one object's section, and the part of the mesh that is this object's. One owner; memory is
// linear in the sections, and an object that does not change costs nothing.
#pragma once

#include <glm/vec3.hpp>
#include <unordered_map>
#include <utility>

#include "base/result.h"
#include "client/mesh/objects/object_patcher.h"
#include "client/mesh/objects/object_positions.h"
#include "client/mesh/patch/keyframe_mesh.h"
#include "client/mesh/weights/morph_timing.h"
#include "client/mesh/weights/morphs.h"
#include "proto/codec/object_stream.h"

namespace foreland::client {

class ObjectReplica {
 public:
  // `objects` must outlive it.
  ObjectReplica(const proto::ObjectSet& objects, size_t object);

  // Reads this object's change at a keyframe that `stream` has begun, and adds the change to `fingerprint`. False if
  // the bytes were no change of this section; the replica is then of no more use.
  [[nodiscard]] bool step(proto::ObjectStream& stream, proto::RangeDecoder& coder, uint32_t& fingerprint);
  // Makes the next mesh, after a step or to extend transitions; what was `to` becomes `from`.
  void blend(const MeshSpan& span, const proto::ObjectStream& stream);
  bool isInTransition() const { return morphs_.isInTransition(); }

  // Whether the object's mesh has changed since the last call.
  bool takeChanged() { return std::exchange(has_changed_, false); }
  const ObjectPatcher& mesh() const { return mesh_; }  // the last one
  uint32_t model() const { return objects_->placement(object_).model; }

  const proto::ObjectSet& set() const { return *objects_; }
  // The newest section, and those that are drawn at the mesh's ends.
  const proto::Section& section() const { return section_; }
  const proto::Section& from() const { return from_; }
  const proto::Section& to() const { return to_; }
  const Morphs& morphs() const { return morphs_; }

  // Valid until the replica changes.
  ObjectPositions positions(const proto::ObjectStream& stream) const {
    return {*objects_, stream, object_, removed_, pose_weights_};
  }

 private:
  double intervals(const MorphTiming& timing, const ObjectPositions& positions, proto::Slot slot) const;
  bool facesAway(const proto::View& from, proto::Slot slot) const;

  const proto::ObjectSet* objects_;
  size_t object_;
  // Nodes that were removed from the section and may still be drawn.
  std::unordered_map<proto::Slot, RemovedNode> removed_;
  PoseWeights pose_weights_;  // of the last mesh
  proto::Section section_;    // the newest that blend() has seen
  proto::Section from_, to_;  // drawn at the mesh's ends
  Morphs morphs_;
  proto::CutDelta delta_;
  bool is_stale_ = true;   // the section has changed since the last mesh, or there is none
  bool is_still_ = false;  // nothing of the last mesh moves
  bool has_changed_ = false;
  ObjectPatcher mesh_;
};

}  // namespace foreland::client
