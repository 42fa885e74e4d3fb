// A change of one object's section as decisions of a range coder: which nodes are removed and added, and the positions
// of added nodes. The server alone tests nodes (refine/adapter.h); both ends hold the same section (surface_cut.h), the
// positions of its nodes and the views of the last two keyframes, and that is what decisions are conditioned on.
//
//   changes   does the section change at all?
//   removed   from the finest level to the coarsest, for each 64 slots with leaves: is any removed? If so, which?
//   added     from the coarsest level to the finest, the same for addable nodes
//   position  of an added node, unless it is known: by how much each coordinate differs from what is expected
//   moves     of the same node, if its model has poses (section/poses.h): likewise, pose by pose
//
// Contexts of a decision about a node are its level, where on the screen it is, whether it looks larger than at the
// last view, and how many of its parents' other children are there. docs/decisions/0014 has the measurements.
//
// The model keeps what it has learnt, for all objects of a session. Any bytes end in a closed section or in an Error,
// in time linear in the frontier and the bytes. One owner; any thread; portable to WebAssembly.
#pragma once

#include <array>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>

#include "proto/codec/surface_cut.h"
#include "proto/codec/symbols.h"
#include "proto/section/poses.h"
#include "proto/space/view.h"

namespace foreland::proto {

// The position nearest to this one within kMaxObjectQuanta: what is in files is not trusted, and a message cannot tell
// of others.
inline glm::ivec3 positionWithin(const glm::ivec3& position) {
  return glm::clamp(position, glm::ivec3(-kMaxObjectQuanta), glm::ivec3(kMaxObjectQuanta));
}

// What both ends have learnt.
struct SurfaceModel {
  static constexpr size_t kLevels = 4, kTrends = 5, kScreens = 8, kSiblings = 4, kScales = 16, kAxes = 4;
  using NodeContexts = std::array<AdaptiveBit, kLevels * kTrends * kScreens>;

  std::array<AdaptiveBit, 4> changes;
  std::array<std::array<AdaptiveBit, 8 * 4>, 2> blocks;  // of removals, of additions
  NodeContexts removed;
  std::array<NodeContexts, 2 * kSiblings> added;  // of nodes that were addable before the step, then of others
  std::array<NumberModel, kScales * kAxes> position, move;
  EscapeModel escape;
};

// The positions of one model's nodes that were sent for any of its objects. A node is known from when it is sent until
// no object's section has it and it is forgotten.
class KnownPositions {
 public:
  struct Node {
    glm::ivec3 position{0}, displacement{0};      // quanta
    uint32_t uses = 0;                            // sections that have it
    std::shared_ptr<const glm::ivec3[]> moves{};  // as many as its model has poses, less one
  };
  const Node* find(Slot slot) const {
    const auto it = nodes_.find(slot);
    return it == nodes_.end() ? nullptr : &it->second;
  }
  void learn(Slot slot, Node node) { nodes_[slot] = std::move(node); }
  void use(Slot slot) { used_ += nodes_[slot].uses++ == 0 ? 1 : 0; }
  void release(Slot slot) { used_ -= --nodes_[slot].uses == 0 ? 1 : 0; }
  // Forgets the nodes that no section has; forgetIfMost() only if they are most of the known ones, `spare` not counted.
  // Both ends do so at the same time.
  void forgetUnused();
  void forgetIfMost(size_t spare) {
    if (nodes_.size() > 2 * used_ + kFew + spare) forgetUnused();
  }
  size_t size() const { return nodes_.size(); }

 private:
  static constexpr size_t kFew = 1024;
  std::unordered_map<Slot, Node> nodes_;
  size_t used_ = 0;
};

// The middle of a node's edge, whose ends are base vertices or known; quanta.
glm::ivec3 middleOfEdge(const MeshTopology& mesh, std::span<const glm::ivec3> base, const KnownPositions& known,
                        NodeId n);

// The moves of a vertex: of a base vertex, or of a node that is known.
std::span<const glm::ivec3> movesOf(const MeshTopology& mesh, std::span<const glm::ivec3> base_moves, size_t each,
                                    const KnownPositions& known, NodeId v);

// What is known of one object on either end. A view; its parts must outlive it.
struct SurfaceCodecState {
  std::span<const glm::ivec3> base;  // positions, quanta
  std::span<const glm::ivec3> base_moves;
  size_t moves_each;         // of a vertex
  double quantum_m;          // metres of the object's frame
  View view;                 // of the keyframe, in the object's frame
  std::optional<View> last;  // of the keyframe before, if this connection had one
  SurfaceCut& cut;
  uint8_t& has_changed;   // in the last keyframe
  KnownPositions& known;  // of its model
  SurfaceModel& model;
};

// Where an encoder's bits went, and for how many.
struct SurfaceBits {
  double structure = 0, positions = 0;     // moves count as positions
  uint64_t added = 0, positions_sent = 0;  // added nodes; those of them whose position was not known yet
};

// Steps the section by `delta` and writes it.
void encodeSurface(const SurfaceCodecState& end, const CutDelta& delta, const ModelNodes& nodes, RangeEncoder& coder,
                   SurfaceBits& bits);
// Reads a change, steps the section by it, and puts it into `delta`, ascending. False if the bytes are no change of
// this section, or the section would exceed `max_nodes`: the state must not be used after that.
[[nodiscard]] bool decodeSurface(const SurfaceCodecState& end, RangeDecoder& coder, size_t max_nodes, CutDelta& delta);

}  // namespace foreland::proto
