// TerrainPatcher changes the terrain's mesh of one interval into that of the next, by as much work as nodes change. The
// meshes equal those that oracle::MeshBuilder makes from nothing, bit for bit, but for the order of vertices and
// triangles.
//
// The patcher keeps the mesh's vertices with their state at the newest end, which is where the next mesh begins. A step
//   1. brings the state to the next mesh's beginning: nodes that jump are removed, moved and added,
//   2. brings the state to that mesh's end: nodes that are not drawn there are removed, nodes whose weight or height
//      changes are moved, and nodes that are drawn there only are added.
// A vertex's normal is an exact sum over its triangles (face_normal.h), so adding or removing a node subtracts the
// triangles that the change ends and adds those that it makes. The triangles of the mesh are those of the union of both
// ends' sections: a node that enters the union halves one or two triangles, and a node that leaves it merges them
// again.
//
// One owner. step() costs O(nodes changed or in transition + edges that cross the data's border); while scene time
// advances it costs O(mesh), to find what the ground moves. rebuild() costs O(mesh).
#pragma once

#include <span>
#include <vector>

#include "client/mesh/patch/blend_patch.h"
#include "client/mesh/patch/face_normal.h"
#include "client/mesh/patch/triangle_places.h"
#include "client/mesh/terrain/border_cuts.h"
#include "client/mesh/terrain/ground_point.h"
#include "client/mesh/terrain/held_nodes.h"
#include "client/mesh/terrain/patch_writer.h"
#include "client/mesh/terrain/terrain_vertices.h"
#include "client/mesh/weights/blend_position.h"
#include "client/mesh/weights/morphs.h"
#include "proto/refine/metric/terrain_domain.h"

namespace foreland::client {

// TerrainStep says what the next mesh shows. `nodes` and `morphs` have been stepped to that mesh. A step owns nothing.
struct TerrainStep {
  const HeldNodes& nodes;
  const Morphs& morphs;
  const EndHeights& heights;
  Time scene_from, scene_to;  // Scenes without epochs ignore these.
  glm::dvec3 origin;          // The mesh's positions are relative to the origin.
  uint32_t order = 1;         // A mesh of order n blends n + 1 keyframes.
};

class TerrainPatcher {
 public:
  // `domain` must outlive the patcher.
  explicit TerrainPatcher(const proto::TerrainDomain& domain);

  // Makes the mesh from nothing. Must be called before step().
  void rebuild(const TerrainStep& step, BlendPatch& out);
  // Makes the mesh from the last one, or from nothing where too many vertex places would be free (kFewPlaces).
  void step(const TerrainStep& step, BlendPatch& out);

  // The numbers of nodes that the last mesh draws at its beginning and at its end.
  uint32_t fromNodes() const { return from_nodes_; }
  uint32_t toNodes() const { return section_nodes_; }
  size_t bytes() const { return vertices_.bytes() + triangles_.bytes(); }

 private:
  using Slots = std::vector<proto::Slot>;
  // A Move says where a vertex of the newest end's section will be, and whether that is where the vertex's node is.
  struct Move {
    uint32_t vertex;
    GroundPoint point;
    bool is_true;
  };
  enum class End { kFrom, kTo };
  using Places = std::vector<uint32_t>;
  // An entering node gets a vertex. `apexes` are the vertices of the triangles' apexes beside the node's edge, or
  // kNoVertex.
  struct Entering {
    proto::Slot slot;
    proto::NodeId id;
    std::array<uint32_t, 2> apexes;
  };
  // Loops over nodes prefetch the vertices and triangles around the node this many places ahead. No measurement of the
  // value is recorded.
  static constexpr size_t kAhead = 4;

  bool isSparse(size_t used) const { return vertices_.count() > 2 * used + kFewPlaces; }
  bool willBeSparse(const HeldNodes& nodes, const Slots& leaving, const Slots& entering) const;
  void advance(const TerrainStep& step, BlendPatch& out);
  void touchCurved();
  void writeBends(BlendPatch& out) const;
  void addBaseVertex(uint32_t x, uint32_t y);
  void addBaseVertices();
  void addRootTriangles(uint32_t root_x, uint32_t root_y);
  uint32_t placeOf(proto::NodeId v) const;
  uint32_t triangleAcross(proto::NodeId apex, proto::NodeId child) const;

  // These functions change the union of both ends' sections.
  void splitUnion(const Slots& slots);
  void split(const Entering& entering);
  void mergeUnion(const Slots& slots);
  void merge(proto::Slot slot, uint32_t v);
  void setLeaf(uint32_t apex, uint32_t q);
  void dropLeaf(uint32_t apex, uint32_t q);
  BorderCuts::Mesh mesh() { return {vertices_, triangles_, *writer_}; }

  Places placesOf(std::span<const proto::Slot> slots) const;
  void fetchAround(uint32_t v) const;
  void fetchTriangles(uint32_t v) const;

  // These functions change the newest end's section.
  void leaveSection(const Places& removed);
  void enterSection(const Slots& added, const Places& places, End end);
  void enter(uint32_t v, const Move& move);
  void addHalves(uint32_t v, double sign);
  void addNormal(uint32_t a, uint32_t b, uint32_t c, double sign);
  void lieOnEdges(const Places& outside);

  // These functions move vertices that stay in the section (terrain_moves.cpp).
  Slots inTransition(End end) const;
  Slots allInSection(End end) const;
  void moveWithin(End end);
  void collectMoves(const Slots& candidates, End end);
  bool collectBaseMoves(End end);
  bool addMove(const Move& move);
  void addDependents(uint32_t v, Slots& out) const;
  void addDependentsAcross(proto::NodeId id, Slots& out) const;
  void makeMoves();
  void addStars(double sign);
  void sumAllNormals();
  template <class Visit>
  void forStar(uint32_t v, const Visit& visit) const;
  template <class Visit>
  void forStarWithin(uint32_t v, uint32_t apex, uint32_t q, const Visit& visit) const;

  static double weightAt(const Morph& m, End end) { return end == End::kFrom ? m.from : m.to; }
  GroundPoint displacementOf(uint32_t v, proto::Slot slot, End end) const;
  Move drawnAt(uint32_t v, proto::Slot slot, double weight, End end) const;
  DrawnPosition<GroundPoint> willBeAt(uint32_t v) const;
  GroundPoint truePosition(proto::NodeId v, int32_t height, End end) const;
  uint32_t cornerCount() const { return (grid_.shape().roots_x + 1) * (grid_.shape().roots_y + 1); }
  uint32_t baseCount() const { return cornerCount() + grid_.shape().roots_x * grid_.shape().roots_y; }
  const TerrainStep& now() const { return *step_; }

  const proto::TerrainDomain& domain_;
  const proto::GridTopology& grid_;
  const FaceNormal face_normal_;
  const glm::vec2 limit_;  // The data's last samples are at this lattice position.
  TerrainVertices vertices_;
  TrianglePlaces triangles_;
  BorderCuts cuts_;
  Slots leaving_;  // The last mesh's end does not draw these nodes, which ascend.
  glm::dvec3 origin_{0};
  Time scene_time_;  // The newest end shows this scene time.
  uint32_t section_nodes_ = 0, from_nodes_ = 0;
  size_t moving_in_section_ = 0;  // So many vertices of the newest end's section are not where their nodes are.

  // These members are used during a step only.
  const TerrainStep* step_ = nullptr;
  PatchWriter* writer_ = nullptr;
  std::vector<Entering> entering_;
  std::vector<Move> moves_;
  std::vector<uint32_t> move_of_;  // A vertex that is_moving has its index in moves_ here.
};

}  // namespace foreland::client
