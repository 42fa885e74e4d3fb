// Topology of a surface: a triangle base mesh of any shape, refined by one of two rules (THEORY section 2). It says of
// nodes what GridTopology says of a grid's, under the same names, so that refiner, codec and interpolator need not know
// which of them they work on:
//
//   quadrisection  every triangle into four (S 3.4): at most two parents and six children        (quadrisection.h)
//   bisection      Rivara's, the centre of each face inserted (P 2.1): two parents, four children (bisection.h)
//
// Parents of a node of level l lie on level l - 1, children on level l + 1, both are found by integer arithmetic and
// one look-up in the base mesh's adjacency, and a set closed under parents is a conforming mesh (mesh_triangles.h draws
// it). Slots stand level by level; within one, face by face (edge by edge), near ones together. There is one canonical
// id for each vertex; a base vertex's is its number, faces' centres (bisection only) coming after the mesh's own.
//
// Immutable after creation; may be copied and moved; any thread; O(1) but for create.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "base/result.h"
#include "proto/topology/base_mesh.h"
#include "proto/topology/bisection.h"
#include "proto/topology/node.h"
#include "proto/topology/quadrisection.h"

namespace foreland::proto {

enum class MeshRule : uint8_t { kQuadrisection = 0, kBisection = 1 };

// What a surface's topology is made of.
struct MeshShape {
  MeshRule rule = MeshRule::kQuadrisection;
  uint32_t halvings = 1;      // of each edge: a level each by quadrisection, two by bisection
  uint32_t vertex_count = 0;  // of the base mesh
  std::vector<BaseFace> faces;
  bool operator==(const MeshShape&) const = default;
};

class MeshTopology {
 public:
  static constexpr uint32_t kMaxHalvings = 15;
  static constexpr int kMaxLevels = 2 * kMaxHalvings;
  static constexpr Slot kMaxSlots = 0xffffffffu;

  // Refuses an unknown rule, no halvings or more than the limit, base meshes that BaseMesh refuses (by what is wrong
  // first), and kMaxSlots or more slots. O(n log n) in the faces.
  static Result<MeshTopology> create(MeshShape shape);

  MeshRule rule() const { return rule_; }
  uint32_t halvings() const { return halvings_; }
  const BaseMesh& base() const { return base_; }
  MeshShape shape() const { return {rule_, halvings_, base_.vertexCount(), base_.faces()}; }
  // Vertices that stand before all nodes: those of the base mesh and, by bisection, the faces' centres.
  uint32_t baseVertexCount() const { return base_.vertexCount() + (isQuad() ? 0 : base_.faceCount()); }

  int maxLevel() const { return max_level_; }
  // One past the largest slot.
  Slot slotCount() const { return level_offset_[max_level_ + 1]; }
  Slot levelOffset(int level) const { return level_offset_[level]; }

  // True for the ids of base vertices and nodes, false for all other bits.
  bool contains(NodeId n) const {
    if (isBaseVertexId(n)) return baseVertexOf(n) < baseVertexCount();
    return isQuad() ? quad().isNode(patchPointOf(n)) : bisect().isNode(patchPointOf(n));
  }
  bool isBase(NodeId n) const { return isBaseVertexId(n); }
  // 0 for base vertices.
  int level(NodeId n) const {
    if (isBaseVertexId(n)) return 0;
    return isQuad() ? quad().level(patchPointOf(n)) : bisect().level(patchPointOf(n));
  }

  // The two vertices whose midpoint the node refines. Here and below `n` is a node.
  std::array<NodeId, 2> endpoints(NodeId n) const {
    return isQuad() ? quad().endpoints(patchPointOf(n)) : bisect().endpoints(patchPointOf(n));
  }
  // The nodes that must be in a section before `n` can be.
  NodeList<2> parents(NodeId n) const {
    return isQuad() ? quad().parents(patchPointOf(n)) : bisect().parents(patchPointOf(n));
  }
  NodeList<2> parents(NodeId n, int) const { return parents(n); }  // of a node whose level is known
  // The nodes of which `n` is a parent.
  NodeList<6> children(NodeId n) const {
    return isQuad() ? quad().children(patchPointOf(n)) : bisect().children(patchPointOf(n));
  }
  NodeList<6> children(NodeId n, int) const { return children(n); }

  // Whether all parents of a child of `n` but `n` itself, of which there is at most one, are there: isThere(NodeId).
  template <class IsThere>
  bool hasOtherParent(NodeId child, NodeId n, const IsThere& isThere) const {
    for (NodeId parent : parents(child))
      if (parent != n && !isThere(parent)) return false;
    return true;
  }

  // Bijection between nodes and (some of the) slots.
  Slot slot(NodeId n) const {
    const PatchPoint p = patchPointOf(n);
    if (isQuad()) return level_offset_[quad().level(p)] + quad().slotInLevel(p);
    return level_offset_[bisect().level(p)] + bisect().slotInLevel(p);
  }
  // The same for a node whose level is known.
  Slot slot(NodeId n, int level) const {
    const PatchPoint p = patchPointOf(n);
    return level_offset_[level] + (isQuad() ? quad().slotInLevel(p) : bisect().slotInLevel(p));
  }
  // The node of a slot, or base vertex 0 if the slot is padding or out of range.
  NodeId node(Slot slot) const {
    if (slot >= slotCount()) return {};
    int level = level_hint_[std::bit_width(slot)];
    while (slot >= level_offset_[level + 1]) ++level;  // levels grow twofold or more, so rarely more than two steps
    const auto within = static_cast<uint32_t>(slot - level_offset_[level]);
    return within < slotsOfLevel(level) ? nodeWithin(level, within) : NodeId{};
  }

  // node() for the slots of one page (kPageSlots, which are all of one level), by their index in it; not for padding.
  class PageNodes {
   public:
    NodeId at(uint32_t low) const { return mesh_->nodeWithin(level_, within_ + low); }

   private:
    friend class MeshTopology;
    const MeshTopology* mesh_;
    int level_;
    uint32_t within_;
  };
  PageNodes pageNodes(int level, Slot first) const {
    PageNodes page;
    page.mesh_ = this;
    page.level_ = level;
    page.within_ = static_cast<uint32_t>(first - level_offset_[level]);
    return page;
  }

  // Where a vertex lies in the parameter domain, in the face that names it. The sum of the weights is weightScale().
  FacePoint facePoint(NodeId v) const;
  // The same point in a given face, which must hold the vertex inside or on its border.
  FacePoint facePointIn(uint32_t face, NodeId v) const;
  uint32_t weightScale() const { return (isQuad() ? 1u : 3u) << halvings_; }

  // The rules themselves; only the one that rule() names.
  Quadrisection quad() const { return {base_, halvings_}; }
  Bisection bisect() const { return {base_, halvings_}; }

 private:
  bool isQuad() const { return rule_ == MeshRule::kQuadrisection; }
  uint64_t slotsOfLevel(int level) const {
    return isQuad() ? quad().slotsOfLevel(level) : bisect().slotsOfLevel(level);
  }
  NodeId nodeWithin(int level, uint32_t within) const {
    return isQuad() ? quad().nodeOfSlot(level, within) : bisect().nodeOfSlot(level, within);
  }
  Status numberSlots();

  BaseMesh base_;
  MeshRule rule_ = MeshRule::kQuadrisection;
  uint32_t halvings_ = 1;
  int max_level_ = 1;
  std::array<Slot, kMaxLevels + 2> level_offset_{};
  std::array<int, kSlotBits + 1> level_hint_{};  // by bit width of a slot: the level of the smallest slot of that width
};

}  // namespace foreland::proto
