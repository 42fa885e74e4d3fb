// What objects may hide, and be hidden by (TOWN): convex solids inside of whatever is drawn of them
// (terrain/surface/inner_solids.h), in the scene's frame, and for each object a box that holds whatever is drawn of it.
// Objects that move, with poses or with the ground, hide nothing; neither do open ones, for they have no solids.
//
// A solid P hides a target, the hull of points t, from all eyes of a capsule, the ball of radius r along a segment, if
// for each end e of the segment and each t some share s of the line from e to t lies at depth (1 - s) r in P or deeper.
//   *Proof.* Depth in a convex P is concave and (1 - s) r is linear. So where lines from both ends to t each have a point
//   that is deep enough, the chord between these points meets the line to t from any eye between the ends at a point
//   that is deep enough as well; likewise between targets. An eye that is v off the segment, |v| <= r, has a line that
//   passes x + (1 - s) v where the first one passes x, and that lies in P.
// All pairs must be met by the same P. What the line meets in P is inside of the object, and the eye is outside of its
// box: so the line enters what is drawn of the object before.
//
// One ray of Embree, from the capsule's middle to the target's, finds all solids that may: user geometry, whose
// callback does the whole test. Immutable; any thread. Cost: about a microsecond a query. Memory: some 400 bytes a
// solid.
#pragma once

#include <array>
#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "base/result.h"
#include "server/section/hierarchy.h"
#include "server/view/eye_capsule.h"

namespace foreland::server {

class ObjectSolids {
 public:
  static constexpr uint32_t kNone = ~0u;

  // Of all objects, whose hulls are known. kLimit if memory does not suffice. O(solids log solids).
  static Result<std::shared_ptr<const ObjectSolids>> create(const SceneObjects& objects);
  ~ObjectSolids();
  ObjectSolids(const ObjectSolids&) = delete;
  ObjectSolids& operator=(const ObjectSolids&) = delete;

  using Corners = std::array<glm::dvec3, 8>;
  // Their hull holds what is drawn of the object, at all scene times. Scene frame, metres.
  const Corners& cornersOf(size_t object) const { return boxes_[object].corners; }

  // A solid that hides the points from all of the eyes; kNone if there is none. `first` is tried first. The target may
  // be drawn up to `rho_m` from the points' hull. Solids of objects to whose boxes the eyes come are left out.
  uint32_t hiding(const EyeCapsule& eyes, std::span<const glm::dvec3> target, double rho_m, uint32_t first) const;

  size_t solidCount() const { return solids_.size(); }
  size_t bytes() const;

 private:
  struct Embree;
  struct Query;
  struct Plane {
    glm::dvec3 normal;
    double offset;
  };
  struct Solid {
    std::array<Plane, 8> planes;
    uint32_t plane_count = 0, object = 0;
    glm::dvec3 low, high;  // scene frame
  };
  struct Box {
    Corners corners;
    // In the object's own frame, to which a point p goes by conjugate(orientation) * (p - position) / scale.
    glm::dvec3 low, high, position;
    glm::dquat orientation;
    double scale;
  };

  ObjectSolids() = default;
  void addObject(const SceneObjects& objects, size_t object);
  void addSolids(const SceneObjects& objects, size_t object);
  Status build();
  bool mayBeInside(const Solid& solid, const EyeCapsule& eyes) const;
  bool hides(const Solid& solid, const Query& query) const;

  std::vector<Solid> solids_;
  std::vector<Box> boxes_;
  glm::dvec3 origin_{0};
  std::unique_ptr<Embree> embree_;
};

}  // namespace foreland::server
