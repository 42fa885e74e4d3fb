// The exact closest point of a triangle mesh, by a bounding volume hierarchy over its triangles. Shares no code with
// the remesher, which it judges. Immutable once made; any thread. Cost: O(n log n) to build, about O(log n) per query
// near the surface.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace foreland::terrain {

// A mesh as spans: the caller keeps it alive.
struct MeshView {
  std::span<const glm::dvec3> positions;
  std::span<const std::array<uint32_t, 3>> faces;
};

struct PointOnMesh {
  double distance = 0;
  uint32_t face = 0;
  glm::dvec3 weights{1, 0, 0};  // of the face's corners; exactly 0 on the sides opposite to them
};

// The closest point of one triangle, as weights of its corners (Ericson, "Real-Time Collision Detection", 5.1.5).
glm::dvec3 closestInTriangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);

class ClosestPoint {
 public:
  explicit ClosestPoint(MeshView mesh);  // at least one face

  const MeshView& mesh() const { return mesh_; }
  PointOnMesh find(const glm::dvec3& p) const;
  // The closest point among the faces whose normal has a positive dot product with `direction`; of all faces if there
  // are none.
  PointOnMesh findFacing(const glm::dvec3& p, const glm::dvec3& direction) const;

  glm::dvec3 positionOf(const PointOnMesh& at) const;
  double distanceToFace(const glm::dvec3& p, uint32_t face) const;

 private:
  struct Node {
    glm::dvec3 low, high;
    uint32_t begin = 0, count = 0;  // leaf: faces in `order_`; inner: count 0, children at begin and begin + 1
  };
  template <bool kFacing>
  PointOnMesh search(const glm::dvec3& p, const glm::dvec3& direction) const;
  void build(uint32_t node, uint32_t begin, uint32_t end);

  MeshView mesh_;
  std::vector<Node> nodes_;
  std::vector<uint32_t> order_;
  std::vector<glm::dvec3> centres_;  // only while building
};

}  // namespace foreland::terrain
