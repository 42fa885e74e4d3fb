// Builds the terrain's part of a keyframe mesh: descends from the root triangles through the union of the sections
// drawn at its two ends, and writes two positions and two normals per vertex and the triangles, clipped to the data.
//   position  from the weights of the nodes at either end (client/mesh/weights/blend_position.h)
//   normal    area-weighted over the triangles of that end's section alone, so shading does not jump where two meshes
//             meet
// Makes a mesh from nothing: for tools, and as the reference that the mesh by change
// (client/mesh/terrain/terrain_patcher.h) must equal. Used once per mesh; one owner. O(vertices).
#pragma once

#include <array>
#include <map>
#include <span>
#include <vector>

#include "client/mesh/patch/complete_normals.h"
#include "client/mesh/patch/face_normal.h"
#include "client/mesh/patch/keyframe_mesh.h"
#include "client/mesh/terrain/curve_bend.h"
#include "client/mesh/terrain/ground_point.h"
#include "client/mesh/terrain/held_nodes.h"
#include "client/mesh/weights/blend_position.h"
#include "proto/refine/metric/terrain_domain.h"

namespace foreland::oracle {

class MeshBuilder {
 public:
  // Fills the terrain's part of `mesh`, whose keyframe headers and origin are set. `morphs` are those of the terrain's
  // nodes. One keyframe more than the `order` is blended.
  MeshBuilder(const proto::TerrainDomain& domain, const client::HeldNodes& nodes, std::span<const client::Morph> morphs,
              const client::EndHeights& heights, client::KeyframeMesh& mesh, uint32_t order = 1);
  void run();

 private:
  struct LatticePoint {
    int32_t x, y;
  };
  // A triangle of the hierarchy: its refinement edge from m - d to m + d, and its apex at m + rot(d).
  struct Triangle {
    LatticePoint m, d;
    uint32_t a, b, apex;  // vertex indices
    int levels_below;     // how often it can be halved
    uint8_t in;           // the sections (HeldNodes::in) of which it is a triangle
  };

  // What is known of a vertex at the two ends of the mesh. In one record, because triangles reach vertices in no order.
  struct Vertex {
    std::array<client::DrawnPosition<client::GroundPoint>, 2> drawn;
    std::array<uint32_t, 2> endpoints{client::kNoVertex, client::kNoVertex};
    std::array<glm::dvec3, 2> normal{};
    uint8_t in = client::kInFrom | client::kInTo;  // the sections (HeldNodes::in) of which it is a vertex
    client::CurveBend bend{};
  };

  void addBaseVertices();
  proto::NodeId nameOf(LatticePoint at) const {
    return grid_.nameIn(root_x_, proto::NodeId::at(static_cast<uint32_t>(at.x), static_cast<uint32_t>(at.y)));
  }
  void visitRoot(uint32_t root_x, uint32_t root_y);
  void visit(const Triangle& t);
  uint32_t vertexOf(const Triangle& t, const client::HeldNodes::Index::Found& node);
  client::GroundPoint positionAt(LatticePoint at, int32_t height, size_t end) const;
  client::GroundPoint truePosition(LatticePoint at, size_t end) const;
  void addNormals(uint8_t sections, const Triangle& t);
  void emit(uint32_t a, uint32_t b, uint32_t c);
  void clip(std::array<uint32_t, 3> corners);
  uint32_t cutEdge(uint32_t inside, uint32_t outside, int axis);
  void finishNormals();
  void writePositions();
  bool isBeyond(uint32_t v, int axis) const { return mesh_.parameters[v][axis] > limit_[axis]; }

  const proto::TerrainDomain& domain_;
  const proto::GridTopology& grid_;
  const client::HeldNodes& held_;
  const client::HeldNodes::Index nodes_;
  const client::EndHeights heights_;
  const client::FaceNormal face_normal_;
  client::KeyframeMesh& mesh_;
  const uint32_t order_;
  glm::vec2 limit_;                       // the data's last samples
  uint32_t root_x_ = 0;                   // the column of the root that is visited
  std::vector<Vertex> vertices_;          // in the order of the descent, so that it finds recent ones in the cache
  std::vector<uint32_t> vertex_of_node_;  // by the node's position in the index; client::kNoVertex until it is reached
  std::map<std::array<uint32_t, 3>, uint32_t> cuts_;  // inside, outside, axis: the vertex on the border
};

}  // namespace foreland::oracle
