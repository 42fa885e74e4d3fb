// The client's copy of one object's section, and the part of the mesh that is this object's: the same union of the
// sections drawn at its two ends with two positions per vertex as the terrain's (replica.h), by the same weights. One
// owner; linear in the sections.
#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <unordered_map>
#include <vector>

#include "base/result.h"
#include "client/keyframe_mesh.h"
#include "client/morph_clock.h"
#include "client/morphs.h"
#include "proto/codec/object_stream.h"

namespace foreland::client {

class ObjectReplica {
 public:
  // `objects` must outlive it.
  ObjectReplica(const proto::ObjectSet& objects, size_t object);

  // Steps to a keyframe, of which `stream` has been told. False if the bytes were no change of this section.
  // `fingerprint` grows by what has changed.
  [[nodiscard]] bool step(proto::ObjectStream& stream, proto::RangeDecoder& coder, uint32_t& fingerprint);
  // To the next mesh; what was `to` becomes `from`. After a step, or because nodes are on their way.
  void blend(const MeshSpan& span, const proto::ObjectStream& stream);
  bool isUnderWay() const { return morphs_.isUnderWay(); }

  // Appends the mesh between the two sections to the objects'.
  void appendTo(KeyframeMesh& mesh) const;

  const proto::Section& section() const { return section_; }
  const Morphs& morphs() const { return morphs_; }

 private:
  // Vertices in the scene's frame, in doubles; made anew when a section changes.
  struct Vertices {
    std::array<std::vector<glm::dvec3>, 2> position;
    std::array<std::vector<uint32_t>, 2> normal;
    // What is drawn: vertices with a place in the image, and triangles of them.
    struct Corner {
      uint32_t vertex;
      glm::vec2 place;
    };
    std::vector<Corner> corners;
    std::vector<uint32_t> indices;
    std::unordered_map<proto::NodeId, uint32_t> numbers;
  };
  class Builder;
  void forgetGone();
  const glm::ivec3& stepsOf(const proto::ObjectStream& stream, proto::Slot slot) const;
  double intervals(const MorphClock& clock, const proto::ObjectStream& stream, proto::Slot slot) const;
  bool facesAway(const proto::View& from, proto::Slot slot) const;

  const proto::ObjectSet* objects_;
  size_t object_;
  std::unordered_map<proto::Slot, glm::ivec3> gone_;  // where nodes are that have gone but may be drawn
  proto::Section section_;                            // the newest that is shown
  proto::Section from_, to_;                          // drawn at the mesh's ends
  Morphs morphs_;
  proto::CutDelta delta_;
  bool is_still_ = false;  // the last mesh was
  Vertices vertices_;
};

}  // namespace foreland::client
