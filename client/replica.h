// The client's copy of its section: steps from keyframe to keyframe as the server does, on what it is sent, and builds
// the mesh between the last two. One owner; no clock, no socket. Memory and time are linear in the sections, not in the
// scene.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "client/held_nodes.h"
#include "client/keyframe_mesh.h"
#include "client/object_replica.h"
#include "proto/delta_codec.h"
#include "proto/frame_grid.h"
#include "proto/message.h"

namespace foreland::client {

class Replica {
 public:
  // The welcome has been decoded, hence checked.
  explicit Replica(const proto::Welcome& welcome);

  // Takes a keyframe: what was `to` becomes `from`. An Error (wrong base, bytes that are no delta, another fingerprint)
  // leaves the sections as they were, and every later keyframe is refused: reconnect.
  Status apply(const proto::KeyframeHeader& header, ByteSpan delta);

  // The newest section of the terrain, to be presented to a server over a new connection; nothing if there is none, or
  // a keyframe broke it. The next keyframe starts from it, or from nothing. Objects start from nothing.
  std::optional<proto::Resume> present(uint64_t scene_id);

  // The mesh between the last two keyframes, origin near the newer one's eye. After the first keyframe: that section,
  // still.
  KeyframeMesh buildMesh() const;

  const proto::GridTopology& grid() const { return domain_->grid; }
  const proto::FrameGrid& frameGrid() const { return domain_->frame; }
  const proto::KeyframeHeader& newest() const { return to_; }
  const HeldNodes& nodes() const { return nodes_; }
  const proto::CutDelta& lastDelta() const { return delta_; }  // sorted
  proto::Section section() const { return nodes_.newest(); }
  const std::vector<ObjectReplica>& objects() const { return objects_; }

  // Height (m) of the newest section's surface at a lattice place inside the data; nothing elsewhere or before a
  // keyframe.
  std::optional<double> heightAt(double x, double y) const;

  // Height in steps of a vertex that the replica holds (base, or node of either section), or nothing.
  std::optional<int32_t> knownHeight(proto::NodeId v) const;

 private:
  void startAfresh();
  void makeObjects();
  Status step(const proto::KeyframeHeader& header, ByteSpan bytes);

  // Behind pointers, for the adapter refers to them and replicas move.
  std::unique_ptr<const proto::TerrainDomain> domain_;
  std::unique_ptr<const std::vector<int32_t>> corner_heights_, centre_heights_;
  proto::TerrainAdapter adapter_;
  proto::DeltaModel model_;  // of all deltas taken
  HeldNodes nodes_;          // and those that can be added to the newest section
  std::unique_ptr<const proto::ObjectSet> object_set_;
  std::vector<ObjectReplica> objects_;
  std::unique_ptr<proto::SurfaceModel> object_model_;  // none without objects: it is large
  uint32_t fingerprint_ = 0;
  proto::KeyframeHeader from_, to_;
  proto::CutDelta delta_;
  proto::AdaptScratch scratch_;
  bool broken_ = false;
};

}  // namespace foreland::client
