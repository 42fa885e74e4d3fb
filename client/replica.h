// The client's copy of its sections. It runs the same adaptation as the server from keyframe to keyframe, on the bytes
// of the deltas, and builds the mesh that blends the last two keyframes, or that shows how far per-node morph timing
// has brought each node. One owner; no clock, no socket. Memory and time are linear in the sections, not in the scene.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "client/mesh/patch/blend_patch.h"
#include "client/mesh/patch/keyframe_mesh.h"
#include "client/mesh/terrain/end_heights.h"
#include "client/mesh/terrain/held_nodes.h"
#include "client/mesh/terrain/terrain_patcher.h"
#include "client/mesh/weights/morph_timing.h"
#include "client/object_patches.h"
#include "client/object_replica.h"
#include "proto/codec/delta_codec.h"
#include "proto/codec/epoch_stream.h"
#include "proto/codec/object_stream.h"
#include "proto/codec/section_codec.h"
#include "proto/message/message.h"
#include "proto/space/frame_grid.h"

namespace foreland::client {

class Replica {
 public:
  // `welcome` has been decoded, and with that validated.
  explicit Replica(const proto::Welcome& welcome);

  // Applies a keyframe: what was `to` becomes `from`. An Error (the delta starts from another keyframe, its bytes are
  // malformed, or the section's fingerprint is not the server's) leaves the drawn sections as they were. Every later
  // delta is then refused, except one that starts from nothing: reconnect.
  Status apply(const proto::KeyframeHeader& header, ByteSpan delta, Blend blend = Blend::kKeyframe);
  // Whether some node is still in transition when the mesh ends.
  bool isInTransition() const;
  // Continues the transitions for another interval while no keyframe arrives. Both ends of the mesh then belong to the
  // newest keyframe.
  void extend(Duration interval, Blend blend);

  // The request to resume from the newest sections over a new connection; nullopt before the first keyframe and after
  // an Error. The next keyframe must start from these sections or from nothing. It says what else of the terrain is
  // remembered, what was used last first, as far as it takes no more than `max_bytes` in all; the rest is forgotten.
  // `welcome` is the new connection's.
  std::optional<proto::Resume> makeResume(const proto::Welcome& welcome, size_t max_bytes = kResumeBytes);
  static constexpr size_t kResumeBytes = 128u << 10;

  // The mesh of the last apply() or extend(), as changes of the one that was made so last: O(changes). The first one is
  // whole, and so is one before which a mesh was left out. Its origin is within kOriginReach_m of the newer keyframe's
  // eye. Reuses the vectors of `out`.
  void makePatch(MeshPatch& out);
  // Such a mesh without vertices and triangles.
  void makeEmptyPatch(MeshPatch& out) const;
  // Memory that makePatch() keeps.
  size_t patcherBytes() const;
  // Positions are floats, so that far from their origin they are coarse: a millimetre at 8 to 16 km.
  static constexpr double kOriginReach_m = 8192;

  // What is known of the terrain, ascending; and beside what is around its section.
  std::vector<proto::KnownPage> knownPages() const { return adapter_.knownPages(); }
  const proto::NodeMemory& memory() const { return adapter_.memory().pages; }
  const proto::GridTopology& grid() const { return domain_->grid; }
  const proto::TerrainDomain& domain() const { return *domain_; }
  const proto::FrameGrid& frameGrid() const { return domain_->frame; }
  const proto::KeyframeHeader& newest() const { return to_; }
  // The terrain's nodes that are drawn at the mesh's two ends, and those of them that are in transition.
  const HeldNodes& nodes() const { return nodes_; }
  const Morphs& morphs() const { return morphs_; }
  const proto::CutDelta& lastDelta() const { return delta_; }  // sorted
  proto::Section section() const { return morphs_.sectionOf(nodes_.newest()); }
  const std::vector<ObjectReplica>& objects() const { return objects_; }
  // Null in scenes without objects.
  const proto::ObjectStream* objectStream() const { return stream_.get(); }
  // The mesh blends one keyframe more than this.
  uint32_t order() const { return order_; }

  // Height (m above the zero surface) of the newest section's surface at a lattice position. Removed nodes that are
  // still drawn refine it further. Nullopt outside the data and before the first keyframe. O(levels).
  std::optional<double> heightAt(double x, double y) const;

  // Height in quanta of a vertex that is drawn (base vertex, or node of either end), at the first epoch in scenes with
  // epochs; nullopt of any other.
  std::optional<int32_t> knownHeight(proto::NodeId v) const;
  // How far the ground has moved at the mesh's two ends.
  EndHeights heights() const {
    return epochs_ ? EndHeights(epochs_->offsets(), from_.scene_time, to_.scene_time) : EndHeights();
  }

 private:
  struct Drawn;
  Drawn reset();
  void restore(Drawn drawn);
  std::vector<proto::KnownPage> encodeHeld(proto::HeldSections& held, size_t max_bytes, Bytes& out) const;
  void makeObjects();
  void setMemory(uint32_t bytes);
  Status step(const proto::KeyframeHeader& header, ByteSpan bytes);
  bool adapt(const proto::KeyframeHeader& header, proto::DeltaDecoder& decoder);
  void blend(MeshSpan span, const proto::CutDelta& change);
  void showNext(uint32_t order, bool is_first);
  double intervals(const MorphTiming& timing, proto::Slot slot) const;

  // Behind pointers, because the adapter refers to them and replicas are moved.
  std::unique_ptr<const proto::TerrainDomain> domain_;
  std::unique_ptr<const std::vector<int32_t>> corner_heights_, centre_heights_;
  proto::TerrainAdapter adapter_;
  proto::DeltaModel model_;  // what the deltas since the last restart have taught the coder
  HeldNodes nodes_;          // with the records of the newest section's addable nodes
  Morphs morphs_;
  Motion motion_;  // between the last two keyframes
  struct SavedRecord {
    proto::Slot slot;
    proto::NodeRecord record;
  };
  std::vector<SavedRecord> saved_;  // scratch of adapt()
  std::unique_ptr<const proto::ObjectSet> object_set_;
  std::vector<ObjectReplica> objects_;
  std::unique_ptr<proto::ObjectStream> stream_;  // null in scenes without objects, because it is large
  std::unique_ptr<proto::EpochStream> epochs_;   // null in scenes without epochs
  uint32_t fingerprint_ = 0;                     // of the newest sections
  proto::KeyframeHeader from_, to_;              // index 0 before the first keyframe
  EarlierKeyframes earlier_;                     // that are blended with them; all of the headers are known
  uint32_t order_ = 1;                           // of the last mesh
  Time shown_until_;                             // by the last mesh, on the path
  proto::CutDelta delta_;
  proto::AdaptScratch scratch_;
  bool is_broken_ = false;  // after an Error
  glm::dvec3 origin_{0};    // of meshes
  glm::dvec3 patched_origin_{0};
  uint64_t meshes_ = 0, patched_ = 0;  // how many there were, and which was patched last
  std::unique_ptr<TerrainPatcher> patcher_;
  ObjectPatches object_patches_;
};

}  // namespace foreland::client
