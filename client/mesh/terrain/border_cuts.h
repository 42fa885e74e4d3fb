// Where the data ends within the roots: leaves of the hierarchy that its far borders cut, and the vertices on the cuts.
// An edge gets its vertex on a border once, so neighbouring triangles share it. A vertex on a cut lies between two
// others, which may themselves lie on the cut by the other border. One owner; a leaf costs O(log cuts), refresh()
// O(cuts), which is as many as edges cross the borders.
#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <map>
#include <vector>

#include "client/mesh/patch/free_places.h"
#include "client/mesh/patch/triangle_places.h"
#include "client/mesh/terrain/patch_writer.h"
#include "client/mesh/terrain/terrain_vertices.h"

namespace foreland::client {

class BorderCuts {
 public:
  // `limit`: the data's last samples.
  explicit BorderCuts(const glm::vec2& limit) : limit_(limit) {}

  // What the leaf's drawn triangles are made with.
  struct Mesh {
    TerrainVertices& vertices;
    TrianglePlaces& triangles;
    PatchWriter& writer;
  };
  static constexpr uint32_t kOwner = 1u << 31;  // set in the owners of places that add() takes

  // Draws what lies within the data; the number of the leaf.
  uint32_t add(const TrianglePlaces::Corners& corners, const Mesh& mesh);
  void remove(uint32_t leaf, const Mesh& mesh);
  // The triangle with this owner has another place now.
  void move(uint32_t owner, uint32_t place) {
    const uint32_t bits = owner & ~kOwner;
    leaves_[bits / 4].triangles[bits % 4] = place;
  }
  // Brings the vertices on cuts to where the ends of their edges are now, if these were touched.
  void refresh(const Mesh& mesh);
  // Calls visit(vertex, inside, outside, share) for each vertex on a cut, which is that share of the way from the one
  // to the other; after those that it lies between.
  template <class Visit>
  void forEach(const Visit& visit) const {
    for (const auto& cuts : cuts_)
      for (const auto& [key, cut] : cuts) visit(cut.vertex, key[0], key[1], cut.at);
  }

 private:
  using Key = std::array<uint32_t, 2>;  // the edge's vertex inside, and the one outside
  struct Cut {
    uint32_t vertex, leaves;  // on how many leaves' outlines it is
    glm::vec2 parameter;
    double at;  // from the vertex inside to the one outside
    bool is_new;
  };
  struct Step {
    int axis;
    Key key;
  };
  struct Leaf {
    std::array<uint32_t, 3> triangles{};
    std::array<Step, 4> cuts{};
    uint32_t triangle_count = 0, cut_count = 0;
  };

  glm::vec2 parameterOf(uint32_t v, const TerrainVertices& vertices) const;
  uint32_t cutEdge(const Step& step, const Mesh& mesh);
  void drawFan(uint32_t leaf, const std::vector<uint32_t>& polygon, const Mesh& mesh);

  glm::vec2 limit_;
  std::array<std::map<Key, Cut>, 2> cuts_;    // by axis
  std::map<uint32_t, glm::vec2> parameters_;  // of vertices on cuts
  std::vector<Leaf> leaves_;
  std::vector<uint32_t> free_leaves_;
  std::vector<uint32_t> polygon_, next_;  // scratch
};

}  // namespace foreland::client
