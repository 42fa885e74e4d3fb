// Whether a block of the terrain is hidden: no point of it, true or drawn, can be seen from any of a set of eyes,
// because a ridge in front of it is higher. Exact in one direction: what is called hidden is hidden.
//
// The eyes are a ball of radius b that is swept along a line (EyeCapsule): where the camera may be now, and is expected
// to be in the next keyframes.
//
// A block of scale t is a square of the lattice with a side of 4 s, s = 2^t (proto/refine/hidden/hidden_blocks.h). It
// is taken as its columns over squares of 2 s, each up to its top (block_tops.h). For a height field a column is hidden
// from its top down, so one line of sight to the top, blocked in front of the block, stands for all below it.
//
// Behind a horizon (horizon.h) each square is hidden or not. The surface may be drawn lower than it is, by what is seen
// as tau, where the horizon is: tops are raised by as much as that is at their own distance.
//
// Without one lines of sight are sampled by rays; that nothing is missed between the samples follows from the
// occluder's steepness k (occluder.h):
//
//   from the ball   Let the line from the raised eye E + (0, 0, b sqrt(1 + k^2)) to a point p be blocked at the share l of its way.
//                   The line from any eye within b of E to p passes there within (1 - l) b of the first, not counting
//                   the raise, and the occluder falls by no more than k times the horizontal part of that: blocked, too.
//   from the capsule  Let x be the distance ahead of the eye, towards the block, and let p lie at (D, u D) ahead and aside, with
//                   the slope m = p_z / D. The line from E + (v_x, v_y, v_z) to p passes at x > v_x beside the line from
//                   E by f (v_y - u v_x), f = (D - x) / (D - v_x), and above it by f (v_z - m v_x). With g = D / (D - v_x),
//                   an eye raised by g (v_z + k |v_y - u v_x| - m v_x) covers it. To fly towards a block costs its slope
//                   only, not k.
//   between lines   Lines to the side by an angle of tangent du pass x du to the side of the first at distance x, where the
//                   occluder is lower by k x du at most: a slope of k du more covers them.
//   what is drawn   The occluder lies below the true surface. Where it blocks the first time, the block is not hidden
//                   itself (the same line shows it), so the surface is drawn there to within tau: tops are raised by as much.
//
// An interval of directions is tried with one line in its middle that covers all of it, and then in halves, until a
// line without any margin passes or the interval is a fraction of a pixel. So what is called visible may yet be hidden.
//
// Pure but for the scratch it is given; any thread. Cost: behind a horizon some 0.1 us; some 0.4 us a ray, 1 to 100
// rays.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/refine/hidden/hidden_blocks.h"
#include "proto/space/view.h"
#include "server/occlusion/horizon/horizon.h"
#include "server/occlusion/scene_occlusion.h"
#include "server/view/eye_capsule.h"

namespace foreland::server {

// How far from its true place the surface may be drawn that hides a block.
struct Tolerance {
  proto::Lens lens;
  double tau_px;
};

class BlockTest {
 public:
  // All must outlive it.
  BlockTest(const Hierarchy& hierarchy, const SceneOcclusion& scene) : hierarchy_(hierarchy), scene_(scene) {}

  // From all of `eyes`, by rays; false if in doubt, and once `max_rays` are used up.
  bool isHidden(const proto::BlockId& block, const Tolerance& tolerance, const EyeCapsule& eyes, uint64_t max_rays);

  // From all eyes of the horizon; false if in doubt.
  bool isBehind(const proto::BlockId& block, const Tolerance& tolerance, Horizon& horizon) const;

  // Whether ridges hide the hull of some points, however the ridges are drawn; likewise.
  bool isBehind(std::span<const glm::dvec3> points, const Tolerance& tolerance, Horizon& horizon) const;
  // The corners of what holds a square of the terrain, true or drawn. Scene frame, metres.
  std::array<glm::dvec3, 8> cornersOf(uint32_t scale, uint32_t i, uint32_t j) const;

  uint64_t rayCount() const { return rays_; }  // since the start

 private:
  // A square of the block in the coordinates of a view of it: metres ahead and height above the eye; `aside` per metre
  // ahead; `slope` is the height per metre ahead that a line from the raised eye must have to pass over the square.
  struct Square {
    double aside_low, aside_high, nearest, farthest, height, slope;
  };
  struct Ahead {
    glm::dvec2 ahead, aside;  // horizontal unit vectors
    glm::dvec3 start;         // of the lines of sight: the raised eye
    double length_m;          // ahead, to the block's nearest point
    double begin_m;           // ahead, where lines begin to count: beyond all eyes
  };

  bool hasSquare(uint32_t scale, uint32_t i, uint32_t j) const;
  bool isBehind(uint32_t scale, uint32_t i, uint32_t j, const Tolerance& tolerance, Horizon& horizon) const;
  bool isBehind(Horizon::Square square, const Tolerance& tolerance, Horizon& horizon) const;
  bool isHullBehind(const GlobeSquares::Hull& hull, const Tolerance& tolerance, Horizon& horizon) const;
  Horizon::Square squareIn(uint32_t scale, uint32_t i, uint32_t j) const;  // tops as they are
  bool collectSquares(const proto::BlockId& block, const glm::dvec3& eye);
  bool raiseEye(const Tolerance& tolerance, const EyeCapsule& eyes);
  bool isCovered(double low, double high, int halvings);
  double slopeOver(double low, double high) const;
  bool isBlocked(double aside, double slope);

  const Hierarchy& hierarchy_;
  const SceneOcclusion& scene_;
  Ahead ahead_{};
  std::vector<Square> squares_;
  double low_ = 0, high_ = 0;  // of all squares
  double finest_ = 0;          // interval that is not halved
  uint64_t rays_ = 0, last_ray_ = 0;
};

}  // namespace foreland::server
