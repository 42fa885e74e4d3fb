// Walks the union of two sections down from the root triangles and writes the mesh between them: two positions and two
// normals per vertex, triangles clipped to the data.
//   position  p_S(v) = own position if v is in S, else the mean of its edge's endpoints (DESIGN section 2)
//   normal    area-weighted over the triangles of S itself, so it depends on S alone and shading does not jump at a keyframe
// Used once per keyframe; one owner. O(vertices).
#pragma once

#include <array>
#include <map>
#include <vector>

#include "client/keyframe_mesh.h"
#include "client/replica.h"

namespace foreland::client {

class MeshBuilder {
 public:
  MeshBuilder(const Replica& replica, KeyframeMesh& mesh);
  void run();

 private:
  struct Lattice {
    int32_t x, y;
  };
  // A triangle: edge a = m - d, b = m + d, apex m + rot(d). `live` says in which sections (HeldNodes::in) it is a
  // triangle.
  struct Triangle {
    Lattice m, d;
    uint32_t a, b, apex;  // vertices
    int levels;           // left below, this one included
    uint8_t live;
  };

  void placeBase();
  void visitRoot(uint32_t root_x, uint32_t root_y);
  void visit(const Triangle& t);
  uint32_t splitVertex(const Triangle& t, const HeldNodes::Row::Found& node);
  void addNormal(uint8_t section, const Triangle& t);
  void emit(uint32_t a, uint32_t b, uint32_t c);
  void clip(std::array<uint32_t, 3> corners);
  uint32_t cut(uint32_t inside, uint32_t outside, int axis);
  void finishNormals();
  void writePositions();
  bool beyond(uint32_t v, int axis) const { return mesh_.places[v][axis] > limit_[axis]; }

  const Replica& replica_;
  const proto::GridTopology& grid_;
  const HeldNodes::Row nodes_;
  KeyframeMesh& mesh_;
  glm::vec2 limit_;
  uint32_t first_node_ = 0;                          // vertices before it are base vertices
  std::array<std::vector<glm::dvec4>, 2> position_;  // of the two sections; scene frame and height, metres
  std::array<std::vector<glm::dvec3>, 2> normal_;
  std::vector<std::array<uint32_t, 2>> endpoints_;    // of node vertices
  std::map<std::array<uint32_t, 3>, uint32_t> cuts_;  // inside, outside, axis: the vertex on the border
};

}  // namespace foreland::client
