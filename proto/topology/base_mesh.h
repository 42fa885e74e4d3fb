// The base complex of a surface: triangles glued along edges, and who is whose neighbour (THEORY section 1). Any
// topology and any valence; closed or with borders; oriented, so that normals and back faces mean something.
//
// Half-edge 3 f + i runs from corner i of face f to the next corner. Two faces that share an edge run along it in
// opposite directions: their half-edges are twins. Edges are numbered by their first half-edge, so edges of faces with
// near numbers have near numbers.
//
// Immutable after creation; any thread; every function is one look-up. Portable to WebAssembly.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/result.h"

namespace foreland::proto {

using BaseFace = std::array<uint32_t, 3>;  // vertices, counter-clockwise seen from outside
using HalfEdge = uint32_t;
inline constexpr HalfEdge kNoHalfEdge = 0xffffffffu;

class BaseMesh {
 public:
  static constexpr uint32_t kMaxVertices = 1u << 20;
  static constexpr uint32_t kMaxFaces = 1u << 20;

  // Refuses what is no oriented manifold with or without border, naming the first face, edge or vertex that is wrong:
  // too many or no faces, vertices out of range, repeated in a face or in no face, edges of more than two faces or run
  // along twice in one direction, vertices where parts of the surface meet in a point only. O(n log n).
  static Result<BaseMesh> create(uint32_t vertex_count, std::vector<BaseFace> faces);

  uint32_t vertexCount() const { return static_cast<uint32_t>(leaving_.size()); }
  uint32_t faceCount() const { return static_cast<uint32_t>(faces_.size()); }
  uint32_t edgeCount() const { return static_cast<uint32_t>(first_.size()); }
  // Edges of one face: those of two have two half-edges.
  uint32_t borderEdgeCount() const { return 2 * edgeCount() - 3 * faceCount(); }
  bool isClosed() const { return borderEdgeCount() == 0; }
  const std::vector<BaseFace>& faces() const { return faces_; }

  static uint32_t face(HalfEdge h) { return h / 3; }
  static HalfEdge next(HalfEdge h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static HalfEdge previous(HalfEdge h) { return h % 3 == 0 ? h + 2 : h - 1; }
  uint32_t vertex(HalfEdge h) const { return faces_[h / 3][h % 3]; }  // where it begins
  HalfEdge twin(HalfEdge h) const { return twin_[h]; }                // kNoHalfEdge on the border
  uint32_t edge(HalfEdge h) const { return edge_[h]; }
  HalfEdge first(uint32_t edge) const { return first_[edge]; }  // of an edge's one or two half-edges, the lower
  bool isFirst(HalfEdge h) const { return first_[edge_[h]] == h; }
  HalfEdge leaving(uint32_t vertex) const { return leaving_[vertex]; }  // one half-edge that begins there

 private:
  Status readFaces(uint32_t vertex_count);
  Status findTwins();
  Status checkFans() const;
  void numberEdges();

  std::vector<BaseFace> faces_;
  std::vector<HalfEdge> twin_;
  std::vector<uint32_t> edge_;
  std::vector<HalfEdge> first_;
  std::vector<HalfEdge> leaving_;  // the one on the border, if the vertex is on it
};

}  // namespace foreland::proto
