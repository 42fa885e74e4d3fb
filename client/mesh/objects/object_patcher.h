// One object's part of the keyframe mesh by change: what ObjectMesh (object_mesh.h) is from nothing, bit for bit, but
// for the order of vertices and triangles. A base face is the unit: what a step changes lies in the faces that hold a
// node in transition, now or in the step before, and only these are cut into triangles again. Of those the triangles
// that were there before keep their places, and a vertex's normal is an exact sum (face_normal.h) that these faces
// leave and join. While a model goes from pose to pose, all faces change.
//
// Numbers of vertices and triangles are the object's own, from 0; client/object_patches.h places objects in one mesh.
// One owner. step(): O(triangles of the faces that change).
#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "client/mesh/objects/object_positions.h"
#include "client/mesh/patch/blend_patch.h"
#include "client/mesh/patch/complete_normals.h"
#include "client/mesh/patch/face_normal.h"
#include "client/mesh/patch/triangle_places.h"
#include "client/mesh/weights/morphs.h"
#include "proto/section/index_table.h"

namespace foreland::client {

class ObjectPatcher {
 public:
  // `objects` must outlive it.
  ObjectPatcher(const proto::ObjectSet& objects, size_t object);

  // Where the ground has carried the object to at a mesh's two ends, scene frame.
  using Carried = std::array<glm::dvec3, 2>;

  // Brings it to the mesh that `morphs` have been stepped to, `positions` known.
  void step(const ObjectPositions& positions, const Morphs& morphs, const Carried& carried);
  // The same where nothing changes but perhaps where the object is.
  void rest(const Carried& carried);
  const Carried& carried() const { return carried_; }

  // Whether the last step gave vertices and triangles other places.
  bool isWhole() const { return is_whole_; }
  // Appends what the last step changed, unless isWhole(), and all there is; positions are relative to `origin`.
  void write(const glm::dvec3& origin, BlendPatch& out) const;
  void writeAll(const glm::dvec3& origin, BlendPatch& out) const;
  // Places of vertices, and triangles.
  uint32_t vertexCount() const { return static_cast<uint32_t>(corners_.size()); }
  uint32_t triangleCount() const { return triangles_.count(); }

  // Whether the node is drawn at either end of the mesh.
  bool isDrawn(proto::Slot slot) const { return vertex_of_.find(slot) != 0 && vertices_[placeOf(slot)].in != 0; }
  // Where a vertex is at the mesh's end, in the scene's frame, and its packed normal there; false if it is none.
  bool findEnd(proto::NodeId v, glm::dvec3& position, uint32_t& normal) const;

  size_t bytes() const;

 private:
  struct Vertex {
    proto::NodeId id;
    proto::Slot slot = 0;  // of a node
    std::array<uint32_t, 2> endpoints{kNoVertex, kNoVertex};
    // At the mesh's two ends, in the object's frame: where it is, and the sum of the normals of its triangles.
    std::array<glm::dvec3, 2> position{}, normal{};
    std::array<uint32_t, 2> packed{}, triangles{};
    std::array<bool, 2> is_true{};
    uint8_t in = 0;                     // the sections that it is a node of: kInFrom | kInTo
    uint32_t first_corner = kNoVertex;  // of a list
    uint32_t seen = 0, moved = 0;       // the steps that did so last
  };
  // A vertex as one face has it: a vertex of the mesh.
  struct Corner {
    uint32_t vertex, face, next;
    uint32_t triangles;  // 0: a free place
    glm::vec2 texture_coordinate;
    bool is_new;
  };
  using Corners = std::array<uint32_t, 3>;  // of a triangle: vertices
  struct Triangle {
    Corners vertices;
    uint32_t place;
  };
  using Face = std::vector<Triangle>;  // of both ends' union, ascending by vertices
  using Ends = std::array<std::vector<Corners>, 2>;
  // A vertex of a face that changes, and what its end was.
  struct Seen {
    uint32_t vertex;
    glm::dvec3 position;
    uint32_t packed;
  };

  uint32_t placeOf(proto::Slot slot) const { return vertex_of_.find(slot) - 1; }
  uint8_t in(proto::NodeId n) const;
  uint32_t vertexOf(proto::NodeId v);
  uint32_t addNode(proto::NodeId v);
  // The nodes of some sections, as mesh_triangles.h asks for them.
  struct InSections {
    const ObjectPatcher& patcher;
    uint8_t sections;
    bool operator()(proto::NodeId n) const {
      const uint8_t in = patcher.in(n);
      return (in & sections) != 0;
    }
    bool mayHold(int32_t half) const { return half >= patcher.finest_; }
  };
  // What a step does to a face: bits.
  enum Change : uint8_t { kMoves = 1, kGrows = 2, kShrinks = 4, kJumps = 8 };
  struct ChangingFace {
    uint32_t face;
    uint8_t changes;
  };
  void addBase();
  void collectFaces(std::span<const proto::Slot> slots, Change change);
  void collectFaces(const Morphs& morphs);
  void stepSections(const Morphs& morphs);
  void setSections(uint32_t v, uint8_t in);
  void update(const ChangingFace& changing);
  void cut(uint32_t face, uint8_t sections, std::vector<Corners>& out);
  void replace(uint32_t face);
  void addTriangle(uint32_t face, Triangle& triangle);
  void removeTriangle(uint32_t face, const Triangle& triangle);
  uint32_t cornerOf(uint32_t face, uint32_t v) const;
  uint32_t addCorner(uint32_t face, uint32_t v);
  void dropCorners();
  void see(uint32_t v);
  void move(uint32_t v);
  void moveBase(uint32_t v);
  void addNormals(uint32_t face, double sign);
  glm::dvec3 unitNormalOf(uint32_t v, size_t end) const;
  void note(const Seen& seen);
  void dropVertices();
  void finishTriangles();
  void compact();
  void clearChanges();
  void carry(const Carried& carried);
  // Of its place in the scene, at an end.
  glm::dvec3 sceneAt(const Vertex& vertex, size_t end) const {
    return objects_->placement(object_).toScene(vertex.position[end]) + carried_[end];
  }
  BlendPatch::Position positionOf(uint32_t corner, const glm::dvec3& origin) const;
  BlendPatch::Normal normalOf(uint32_t corner) const;

  const proto::ObjectSet* objects_;
  size_t object_;
  FaceNormal face_normal_;
  proto::AtlasLayout layout_;
  std::vector<Vertex> vertices_;  // base vertices by their numbers, then nodes
  std::vector<uint32_t> free_vertices_;
  proto::IndexTable vertex_of_;  // of nodes by slot: 1 + place
  std::vector<Corner> corners_;
  std::vector<uint32_t> free_corners_;
  std::vector<Face> faces_;                  // empty before the first step
  std::unordered_map<uint32_t, Ends> ends_;  // of faces whose two ends have different triangles
  TrianglePlaces triangles_;
  std::array<uint32_t, proto::MeshTopology::kMaxHalvings + 1> nodes_{};  // of either section, by scaleLog2
  int32_t finest_ = 0;                                                   // the least power of two of those
  uint32_t steps_ = 0;
  std::vector<proto::Slot> in_transition_;        // in the last step
  std::vector<proto::Slot> differing_;            // nodes of one of the last step's two sections
  std::vector<uint32_t> moved_, turned_, added_;  // corners that the last step changed
  BlendPatch changed_;                            // the triangles
  bool is_whole_ = true;
  PoseWeights poses_;  // in the last step
  Carried carried_{};
  bool is_carried_ = false;  // elsewhere than in the mesh before
  static constexpr size_t kFewCorners = 256;

  // During a step only.
  const ObjectPositions* positions_ = nullptr;
  bool is_posed_ = false;  // its poses move all vertices
  std::span<const Morph> morphs_;
  std::vector<ChangingFace> changing_;
  std::vector<Seen> seen_;
  std::vector<uint32_t> unused_corners_, perhaps_unused_;  // of the last: vertices
  std::vector<Triangle> was_;
  std::vector<Corners> from_, to_, now_;  // a face's triangles of either end, and of both ends' union
};

}  // namespace foreland::client
