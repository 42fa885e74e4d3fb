// The client's copy of its section: steps from keyframe to keyframe as the server does, on what it is sent, and builds
// the mesh between the last two, or as far as its nodes have come on their own clocks. One owner; no clock, no socket.
// Memory and time are linear in the sections, not in the scene.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "client/held_nodes.h"
#include "client/keyframe_mesh.h"
#include "client/morph_clock.h"
#include "client/object_replica.h"
#include "proto/codec/delta_codec.h"
#include "proto/codec/object_stream.h"
#include "proto/message/message.h"
#include "proto/space/frame_grid.h"

namespace foreland::client {

class Replica {
 public:
  // The welcome has been decoded, hence checked.
  explicit Replica(const proto::Welcome& welcome);

  // Takes a keyframe: what was `to` becomes `from`. An Error (wrong base, bytes that are no delta, another fingerprint)
  // leaves the sections as they were, and every later keyframe is refused: reconnect.
  Status apply(const proto::KeyframeHeader& header, ByteSpan delta, Blend blend = Blend::kKeyframe);
  // Whether nodes will not have come to rest when the mesh ends; and their next interval, for when no keyframe has
  // come: both ends of the mesh then are the newest's.
  bool isUnderWay() const;
  void extend(Duration interval, Blend blend);

  // The newest sections, to be presented to a server over a new connection; nothing if there are none, or a keyframe
  // broke them. The next keyframe starts from them, or from nothing.
  std::optional<proto::Resume> makeResume(uint64_t scene_id);

  // The mesh of the last step, origin near the newer keyframe's eye. After the first keyframe: that section, still.
  KeyframeMesh buildMesh() const;

  const proto::GridTopology& grid() const { return domain_->grid; }
  const proto::FrameGrid& frameGrid() const { return domain_->frame; }
  const proto::KeyframeHeader& newest() const { return to_; }
  // Drawn at the two ends of the mesh, and those of them that are on their way.
  const HeldNodes& nodes() const { return nodes_; }
  const Morphs& morphs() const { return morphs_; }
  const proto::CutDelta& lastDelta() const { return delta_; }  // sorted
  proto::Section section() const { return morphs_.sectionOf(nodes_.newest()); }
  const std::vector<ObjectReplica>& objects() const { return objects_; }

  // Height (m) of the newest section's surface, with what is leaving it, at a lattice place inside the data; nothing
  // elsewhere or before a keyframe.
  std::optional<double> heightAt(double x, double y) const;

  // Height in steps of a vertex that is drawn (base, or node of either end), or nothing.
  std::optional<int32_t> knownHeight(proto::NodeId v) const;

 private:
  void startAfresh();
  void makeObjects();
  Status step(const proto::KeyframeHeader& header, ByteSpan bytes);
  void keepLeaving();
  void restoreLeaving();
  void blend(const MeshSpan& span, const proto::CutDelta& change);
  double intervals(const MorphClock& clock, proto::Slot slot) const;

  // Behind pointers, for the adapter refers to them and replicas move.
  std::unique_ptr<const proto::TerrainDomain> domain_;
  std::unique_ptr<const std::vector<int32_t>> corner_heights_, centre_heights_;
  proto::TerrainAdapter adapter_;
  proto::DeltaModel model_;  // of all deltas taken
  HeldNodes nodes_;          // and those that can be added to the newest section
  Morphs morphs_;
  struct Leaving {
    proto::Slot slot;
    proto::NodeRecord record;
  };
  std::vector<Leaving> leaving_;  // while the section steps
  Motion motion_;                 // between the last two keyframes
  std::unique_ptr<const proto::ObjectSet> object_set_;
  std::vector<ObjectReplica> objects_;
  std::unique_ptr<proto::ObjectStream> stream_;  // none without objects: it is large
  uint32_t fingerprint_ = 0;
  proto::KeyframeHeader from_, to_;
  proto::CutDelta delta_;
  proto::AdaptScratch scratch_;
  bool broken_ = false;
};

}  // namespace foreland::client
