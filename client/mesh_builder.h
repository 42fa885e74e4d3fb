// Walks the union of the sections drawn at a mesh's two ends down from the root triangles and writes the mesh between
// them: two positions and two normals per vertex, triangles clipped to the data.
//   position  by the weights of the nodes at either end (blend_position.h)
//   normal    area-weighted over the triangles of that end's own section, so it depends on the end alone and shading does
//             not jump where meshes meet
// Used once per mesh; one owner. O(vertices).
#pragma once

#include <array>
#include <map>
#include <vector>

#include "client/blend_position.h"
#include "client/keyframe_mesh.h"
#include "client/replica.h"
#include "client/settle_normals.h"

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

  // At the two ends of the mesh. All that is needed of it stands together, for vertices are met in no order.
  struct Vertex {
    std::array<Drawn<glm::dvec4>, 2> drawn;  // scene frame and height, metres
    std::array<uint32_t, 2> ends{kNoEnd, kNoEnd};
    std::array<glm::dvec3, 2> normal{};
  };

  void placeBase();
  void visitRoot(uint32_t root_x, uint32_t root_y);
  void visit(const Triangle& t);
  uint32_t splitVertex(const Triangle& t, const HeldNodes::Row::Found& node);
  glm::dvec4 placeOf(Lattice at, int32_t height) const;
  glm::dvec4 knownPlace(Lattice at) const;
  void addNormals(uint8_t sections, const Triangle& t);
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
  std::vector<Vertex> vertices_;   // in the order in which the walk meets them, so it finds its last ones near
  std::vector<uint32_t> numbers_;  // of nodes, by their position in the row
  std::map<std::array<uint32_t, 3>, uint32_t> cuts_;  // inside, outside, axis: the vertex on the border
};

}  // namespace foreland::client
