// Convex solids inside a closed surface: whatever is drawn of the surface (any section, mixes of sections, geomorphs)
// goes around them, so that a line from outside to a point of such a solid meets what is drawn. That is what may hide
// things (server/occlusion).
//
// *Proof.* A vertex n of the full mesh is drawn at p(n) = (p(a) + p(b)) / 2 + w d(n), with any 0 <= w <= 1 (THEORY,
// equation 2). So n's largest dot product with a direction u, over all that may be drawn, is
// (h(a) + h(b)) / 2 + max(0, u . d(n)), with h of its edge's endpoints, and u . p of base vertices. Drawn triangles are
// made of the full mesh's, and linear on each. If each of these has all corners, however drawn, outside of one and the
// same plane of a convex solid, no drawn triangle touches the solid. So none does while weights go from 1, the full
// mesh, to those that are drawn, and around every point of the solid the drawn surface has the winding number that the
// full mesh has around any point of it, which is 1.
//
// Each plane stands off by what the surface can move across it, which is seldom more than largestError and often less:
// what a wall's vertices do along the wall costs nothing. Solids are kept in the object's frame. Immutable; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "proto/section/surface_bounds.h"
#include "terrain/surface/full_mesh.h"
#include "terrain/surface/surface.h"

namespace foreland::terrain {

// A half-space: the points x where dot(normal, x) >= offset. Metres of the object's frame.
struct SolidPlane {
  glm::dvec3 normal{0};  // unit, into the solid
  double offset = 0;

  bool operator==(const SolidPlane&) const = default;
};

// What is in all of its half-spaces; bounded and not empty.
struct ConvexSolid {
  static constexpr size_t kMaxPlanes = 8;
  std::array<SolidPlane, kMaxPlanes> all_planes{};  // zeros after the last
  uint32_t plane_count = 0;
  glm::dvec3 low{0}, high{0};  // a box that holds it

  std::span<const SolidPlane> planes() const { return std::span(all_planes).first(plane_count); }
};

struct InnerSolids {
  static constexpr size_t kMaxSolids = 4;
  std::vector<ConvexSolid> solids;  // they may overlap
  double volume_share = 0;          // of the union, of the surface's volume
};

// What half-spaces have in common, by its outline: of each plane the polygon that it bounds the solid by, empty for a
// plane that it does not touch.
struct SolidShape {
  std::vector<std::vector<glm::dvec3>> polygons;
  glm::dvec3 low{0}, high{0}, middle{0};  // the mean of the polygons' corners
  double volume = 0;
  double thickness = 0;  // the least extent across one of the planes that it touches
};
// Without polygons if it is empty or reaches farther than `reach` from the origin on an axis. O(n^3).
SolidShape shapeOf(std::span<const SolidPlane> planes, double reach);

// The solid of up to kMaxPlanes planes with its box; without planes if shapeOf finds none.
ConvexSolid makeSolid(std::span<const SolidPlane> planes, double reach);

// Where vertices may be drawn.
class DrawnExtents {
 public:
  // `mesh` is the surface's. Both must outlive it.
  DrawnExtents(const TrueSurface& surface, const FullMesh& mesh);

  // For each vertex of the full mesh: the largest dot product of `direction` with a position that it may be drawn at.
  // O(vertices).
  void along(const glm::dvec3& direction, std::vector<double>& out) const;
  // What rounding may add to these.
  double pad() const { return pad_m_; }
  // No coordinate of what is drawn is larger.
  double reach() const { return reach_m_; }
  // The largest distance of a vertex from where it may be drawn, at most sqrt(3) times too large.
  double largestDeviation() const;

 private:
  const FullMesh& mesh_;
  size_t base_vertices_;
  struct Node {
    uint32_t vertex, a, b;
  };
  std::vector<Node> nodes_;  // coarse levels first
  double pad_m_ = 0, reach_m_ = 0;
};

// A box with sides along the axes.
struct DrawnBox {
  glm::dvec3 low{0}, high{0};
};
// For each base face a box that holds it, as it truly is and however it is drawn, in all poses. Object's frame. O(poses
// times vertices and triangles).
std::vector<DrawnBox> boxesOfFaces(const TrueSurface& surface);

// The number of times that a closed mesh goes around a point that is not on it.
double windingNumber(const FullMesh& mesh, const glm::dvec3& point);

// Whether nothing that is drawn of the surface touches the solid and it is inside: by the proof above, with all
// triangles. False for a surface with a border, and for one with several poses. O(vertices and triangles).
bool isInside(const ConvexSolid& solid, const TrueSurface& surface);

// A bound of how far any point of the surface may be drawn from where it truly is, by the records of its nodes
// (bounds.h); metres of the object's frame. O(nodes of the coarsest level): coarse records hold fine ones.
double largestError(const proto::MeshTopology& topology, std::span<const proto::SurfaceRecord> records);

}  // namespace foreland::terrain
