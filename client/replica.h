// The client's copy of its section: applies cut deltas after checking them, and builds the mesh between the last two
// keyframes. One owner; no clock, no socket. Memory and time are linear in the sections, not in the scene.
#pragma once

#include <optional>
#include <vector>

#include "client/keyframe_mesh.h"
#include "client/slot_table.h"
#include "proto/delta_codec.h"
#include "proto/frame_grid.h"
#include "proto/message.h"

namespace foreland::client {

// The nodes of the last two sections together, by ascending slot, and which of the two each belongs to.
struct NodeUnion {
  static constexpr uint8_t kInFrom = 1, kInTo = 2;

  std::vector<proto::Slot> slots;
  std::vector<int32_t> heights;  // steps
  std::vector<uint8_t> in;       // kInFrom | kInTo
  SlotTable index;               // slot to position in the arrays above
};

class Replica {
 public:
  // The welcome has been decoded, hence checked.
  explicit Replica(const proto::Welcome& welcome);

  // Takes a keyframe: what was `to` becomes `from`. An Error (wrong base, unknown or doubled nodes, a missing parent,
  // another fingerprint) leaves the replica as it was.
  Status apply(const proto::KeyframeHeader& header, ByteSpan delta);

  // The mesh between the last two keyframes, origin near the newer one's eye. After the first keyframe: that section,
  // still.
  KeyframeMesh buildMesh() const;

  const proto::GridTopology& grid() const { return grid_; }
  const proto::FrameGrid& frameGrid() const { return frame_; }
  const proto::KeyframeHeader& newest() const { return to_; }
  const NodeUnion& nodes() const { return nodes_; }
  const proto::CutDelta& lastDelta() const { return delta_.cut; }
  proto::Section section() const;  // the newest

  // Height (m) of the newest section's surface at a lattice place inside the data; nothing elsewhere or before a
  // keyframe.
  std::optional<double> heightAt(double x, double y) const;

  // Height in steps of a vertex that the replica holds (base, or node of either section), or nullptr.
  const int32_t* knownHeight(proto::NodeId v) const;

 private:
  Status checkClosure(const NodeUnion& next, const proto::CutDelta& cut) const;

  proto::GridTopology grid_;
  proto::FrameGrid frame_;
  std::vector<int32_t> corner_heights_, centre_heights_;
  NodeUnion nodes_;
  proto::DeltaModel model_;  // of all deltas taken
  uint32_t fingerprint_ = 0;
  proto::KeyframeHeader from_, to_;
  proto::HeightDelta delta_;
};

}  // namespace foreland::client
