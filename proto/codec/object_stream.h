// What both ends hold of the objects that are sent to a viewer, object by object and keyframe by keyframe: the
// sections, the positions of their nodes, and what the coder has learnt. The server writes each object's change, the
// client reads it, and both hold the same. A node's position is sent once for all objects of a model (KnownPositions in
// surface_codec.h), and is remembered as long as there is memory for it.
//
// It begins with empty sections, no known positions and a new model, and does so again after a keyframe from nothing.
// After a client has resumed on a new connection, both ends know the positions of its sections' nodes, and nothing
// else. One owner (a session, a replica). Memory is linear in the sections. Portable to WebAssembly.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "proto/codec/surface_codec.h"
#include "proto/refine/surface/objects.h"

namespace foreland::proto {

// Nodes of all objects' sections that a client accepts.
inline constexpr size_t kMaxObjectNodes = 1u << 24;

class ObjectStream {
 public:
  // `objects` must outlive it.
  explicit ObjectStream(const ObjectSet& objects);

  // How many bytes the client spares for what it does not need now, terrain included.
  void setMemory(uint64_t bytes);

  // At the client, when it resumes on a new connection.
  void restart();
  // At the server, when it resumes: one object's. `nodes` of its model.
  void hold(size_t object, const Section& section, const ModelNodes& nodes);

  // A keyframe; then each object's change follows, in their order.
  void begin(const View& view);
  // What the object's section becomes by `delta`; `nodes` of its model.
  void encode(size_t object, const CutDelta& delta, const ModelNodes& nodes, RangeEncoder& coder, SurfaceBits& bits);
  // Reads a change into `delta`, ascending. False if the bytes were none: this is then of no more use.
  [[nodiscard]] bool decode(size_t object, RangeDecoder& coder, CutDelta& delta);

  const SurfaceCut& cut(size_t object) const { return cuts_[object]; }
  Section section(size_t object) const { return cuts_[object].section(); }
  // Of a node of the object's section, or of the one before it; quanta of its model.
  const glm::ivec3& position(size_t object, Slot slot) const;
  std::span<const glm::ivec3> moves(size_t object, Slot slot) const;

 private:
  SurfaceCodecState endOf(size_t object);

  const ObjectSet* objects_;
  std::vector<SurfaceCut> cuts_;
  std::vector<uint8_t> has_changed_;   // in the last keyframe
  std::vector<KnownPositions> known_;  // of each model
  SurfaceModel model_;
  std::optional<View> view_, last_;
  size_t nodes_ = 0;
  size_t spare_nodes_ = 0;  // that no section has and that are known all the same, of each model
};

}  // namespace foreland::proto
