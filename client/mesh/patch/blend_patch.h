// What turns the blended mesh of one interval into that of the next: only the vertices and triangles that change.
// Vertices and triangles keep their indices, which are recycled once they are free. Triangles are always dense. Vertex
// indices are not: places that no triangle refers to keep what they last held, and are at most as many as those in
// use, plus kFewPlaces (BlendPatch::is_whole ends it).
//
// What a mesh ends with is what the next one begins with, so a patch says nothing of vertices that come to rest there:
// whoever applies it (PatchedMesh) moves their `to` to `from`. Plain data; immutable once made.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "client/mesh/patch/keyframe_mesh.h"

namespace foreland::client {

inline constexpr uint32_t kFewPlaces = 4096;

struct BlendPatch {
  struct Position {
    uint32_t vertex;
    glm::vec4 from, to;
  };
  struct Moved {
    float from, to;
  };
  struct Bend {
    glm::vec3 from{0}, to{0};
  };
  struct Normal {
    uint32_t vertex;
    uint32_t from, to;
  };
  struct Parameter {
    uint32_t vertex;
    glm::vec2 parameter;
  };
  struct Triangle {
    uint32_t place;  // its number, in `indices` / 3
    std::array<uint32_t, 3> corners;
  };

  bool is_whole = false;  // the mesh is made anew: nothing of the last one stays
  uint32_t vertex_count = 0, triangle_count = 0;
  std::vector<Position> positions;
  bool tells_moved = false;  // the ground moves (BlendMesh::from_moved)
  std::vector<Moved> moved;  // of `positions`, if it does
  bool tells_bends = false;  // vertices move on curves (BlendMesh::from_bends)
  std::vector<Bend> bends;   // of `positions`, if they do
  std::vector<Normal> normals;
  std::vector<Parameter> parameters;  // of vertices that are new
  std::vector<Triangle> triangles;

  // Nothing changes; memory is kept.
  void clear() {
    is_whole = tells_moved = tells_bends = false;
    vertex_count = triangle_count = 0;
    positions.clear(), moved.clear(), bends.clear(), normals.clear(), parameters.clear(), triangles.clear();
  }
};

// The next mesh of the terrain and all objects.
struct MeshPatch {
  proto::KeyframeHeader from, to;
  EarlierKeyframes earlier{};
  glm::dvec3 origin{0};
  uint32_t from_nodes = 0, to_nodes = 0;
  BlendPatch terrain{}, objects{};
  std::vector<ObjectPart> object_parts{};

  void clear() {
    terrain.clear(), objects.clear();
    object_parts.clear();
  }
};

// Elements [begin, end) of an array.
struct Range {
  uint32_t begin, end;
  bool operator==(const Range&) const = default;
};

// Which elements of a mesh's arrays have changed: vertices, and triangles. Ascending, disjoint.
struct ChangedRanges {
  std::vector<Range> from_positions, to_positions, bends, from_normals, to_normals, parameters, triangles;
  bool tells_moved = false;  // the ranges of positions are also those of BlendMesh::from_moved and to_moved

  void clear();
  // What an upload of the ranges takes, and in how many parts it is.
  size_t bytes() const;
  size_t count() const;
};
// What an upload of the whole mesh takes.
size_t bytesOf(const BlendMesh& mesh);

// Changes that are closer in an array than so many bytes are uploaded together with what lies between: a call of the
// graphics interface costs a page about as much as they do (docs/decisions/0028-meshes-by-change.md).
inline constexpr size_t kUploadGap = 512;

// A blended mesh that is brought up to date by patches, and what has changed in it since clearChanges(). One owner.
class PatchedMesh {
 public:
  explicit PatchedMesh(BlendMesh& mesh) : mesh_(&mesh) {}

  // The patches of one source, each once and in their order, from a whole one on. O(patch).
  void apply(const BlendPatch& patch);

  bool isAllChanged() const { return is_all_changed_; }
  // Ranges that have changed, unless all has; those less than `gap` bytes apart are made one. O(changes + mesh / 64).
  void collectChanges(size_t gap, ChangedRanges& out);
  void clearChanges();

 private:
  void resize(const BlendPatch& patch);
  void settle();
  void applyMoved(const BlendPatch& patch);
  void applyBends(const BlendPatch& patch);
  size_t noted() const;

  BlendMesh* mesh_;
  // Vertices that are not at rest since the last patch: whose positions, or normals, differ at the ends, or which bend.
  std::vector<uint32_t> moving_, turning_, bending_;
  // Since clearChanges(), in no order and perhaps more than once; of all channels of a vertex.
  std::vector<uint32_t> from_positions_, to_positions_, bends_, from_normals_, to_normals_, parameters_, triangles_;
  bool is_all_changed_ = true;
};

}  // namespace foreland::client
