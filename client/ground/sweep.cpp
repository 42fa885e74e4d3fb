#include "client/ground/sweep.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

namespace foreland::client {

namespace {

constexpr double kNoFloor = -std::numeric_limits<double>::infinity();
// Straight lines are bent on the lattice of a geographic scene: 5 mm over such a length.
constexpr double kLongestPiece_m = 500;
constexpr double kTurn = 6.283185307179586;
// Of a piece's length: beyond a border, to be sure which cell comes next.
constexpr double kNudge = 1e-9;
constexpr double kTouch = 1e-6;  // sample intervals; more than motions go beyond a border

// A straight motion on the lattice.
struct StraightMotion {
  proto::LatticePosition from;
  glm::dvec2 across{0, 0};  // sample intervals
  double rise_m = 0;
  double level_m = 0;  // without the rise
  glm::dvec2 at(double s) const { return glm::dvec2(from.x, from.y) + s * across; }
};

// The floor over a part of a motion: one straight line.
struct FloorPart {
  double begin, end;  // of the motion's 0 to 1
  double low_m, high_m;
};

class Glide {
 public:
  Glide(const GroundHeights& ground, double clearance_m) : ground_(ground), clearance_m_(clearance_m) {}

  // Moves; gives where the eye is then.
  proto::LatticePosition run(const StraightMotion& motion) {
    height_m_ = motion.from.height_m;
    left_m_ = std::hypot(motion.level_m, motion.rise_m);
    const double missing_m = std::max(0.0, lowestFloorAt(motion.at(0)) - height_m_);
    lifted_m_ = {missing_m, std::max(0.0, missing_m - motion.level_m)};
    double s = 0;
    while (s < 1) {
      const auto cell = cellAfter(motion, s);
      const double end = borderAfter(motion, cell, s), crease = creaseBetween(motion, cell, s, end);
      const double stopped = follow(motion, partOf(motion, cell, s, crease));
      s = stopped < crease || crease >= end ? stopped : follow(motion, partOf(motion, cell, crease, end));
      if (s < end) break;
    }
    const glm::dvec2 at = motion.at(std::min(s, 1.0));
    return {at.x, at.y, height_m_};
  }
  bool hasTouched() const { return has_touched_; }

 private:
  std::optional<GroundCell> cellAfter(const StraightMotion& m, double s) const {
    return ground_.cellAt(m.at(s + kNudge));
  }

  // Where the motion leaves the cell, or a square where nothing is known: what is known may begin half a sample
  // interval before a sample.
  static double borderAfter(const StraightMotion& m, const std::optional<GroundCell>& cell, double s) {
    const glm::dvec2 here = m.at(s + kNudge);
    const double side = cell ? cell->side : 0.5;
    const glm::dvec2 low = cell ? cell->low : side * glm::floor(here / side);
    double end = 1;
    for (const int axis : {0, 1}) {
      const double along = m.across[axis];
      if (along == 0) continue;
      const double border = along > 0 ? low[axis] + side : low[axis];
      const double start = axis == 0 ? m.from.x : m.from.y;
      end = std::min(end, (border - start) / along);
    }
    return std::min(1.0, std::max(end, s + kNudge));
  }

  // The two planes of the surface that bulges, of which the lower one counts: over the diagonal that is higher.
  static glm::dvec2 planesAt(const GroundCell& c, glm::dvec2 at) {
    const glm::dvec2 t = (at - c.low) / c.side;
    const double *h = c.heights_m, sw = h[0], se = h[1], nw = h[2], ne = h[3];
    if (sw + ne >= se + nw) return {sw + t.x * (se - sw) + t.y * (ne - se), sw + t.x * (ne - nw) + t.y * (nw - sw)};
    return {sw + t.x * (se - sw) + t.y * (nw - sw), ne + (1 - t.x) * (nw - ne) + (1 - t.y) * (se - ne)};
  }
  // Where both planes are equally high between two places, or `end`.
  static double creaseBetween(const StraightMotion& m, const std::optional<GroundCell>& cell, double begin,
                              double end) {
    if (!cell) return end;
    const glm::dvec2 a = planesAt(*cell, m.at(begin)), b = planesAt(*cell, m.at(end));
    const double before = a.x - a.y, after = b.x - b.y;
    if (!((before < 0 && after > 0) || (before > 0 && after < 0))) return end;
    return begin + (end - begin) * before / (before - after);
  }

  double floorAt(const std::optional<GroundCell>& cell, glm::dvec2 at) const {
    if (!cell) return kNoFloor;
    const glm::dvec2 planes = planesAt(*cell, at);
    return std::min(planes.x, planes.y) + cell->coarse_m + clearance_m_;
  }
  // Of all cells that a place touches: an eye that stopped before a wall is not in it.
  double lowestFloorAt(glm::dvec2 at) const {
    double lowest_m = -kNoFloor;
    for (const double x : {at.x - kTouch, at.x + kTouch})
      for (const double y : {at.y - kTouch, at.y + kTouch})
        lowest_m = std::min(lowest_m, floorAt(ground_.cellAt({x, y}), at));
    return lowest_m;
  }
  FloorPart partOf(const StraightMotion& m, const std::optional<GroundCell>& cell, double begin, double end) const {
    const auto lifted = [&](double s) {
      return floorAt(cell, m.at(s)) - (lifted_m_.x + s * (lifted_m_.y - lifted_m_.x));
    };
    return {begin, end, lifted(begin), lifted(end)};
  }

  // Follows the motion over a part, gliding where the floor is in the way; gives where it comes to.
  double follow(const StraightMotion& m, const FloorPart& part) {
    if (part.low_m > height_m_ && !climb(part.low_m - height_m_)) return part.begin;
    const double length = part.end - part.begin;
    const double free_end_m = height_m_ + m.rise_m * length;
    if (free_end_m >= part.high_m) return travel(m, part.begin, part.end, free_end_m);
    // Down to where both lines meet, then along the floor.
    const double above_m = std::max(height_m_ - part.low_m, 0.0), missing_m = part.high_m - free_end_m;
    const double meet = part.begin + length * above_m / (above_m + missing_m);
    has_touched_ = true;
    if (travel(m, part.begin, meet, height_m_ + m.rise_m * (meet - part.begin)) < meet) return stopped_;
    return travel(m, meet, part.end, part.high_m);
  }
  bool climb(double rise_m) {
    has_touched_ = true;
    const double climbed_m = std::min(rise_m, left_m_);
    height_m_ += climbed_m, left_m_ -= climbed_m;
    return climbed_m == rise_m;
  }
  // As far as there is way left to go.
  double travel(const StraightMotion& m, double begin, double end, double end_m) {
    const double way_m = std::hypot(m.level_m * (end - begin), end_m - height_m_);
    // Without the ground in the way nothing is cut off.
    const double share = !has_touched_ || way_m <= left_m_ ? 1 : left_m_ / way_m;
    left_m_ = std::max(0.0, left_m_ - way_m);
    height_m_ = share == 1 ? end_m : height_m_ + share * (end_m - height_m_);
    stopped_ = share == 1 ? end : begin + share * (end - begin);
    return stopped_;
  }

  const GroundHeights& ground_;
  double clearance_m_;
  double height_m_ = 0, left_m_ = 0, stopped_ = 0;
  glm::dvec2 lifted_m_{0, 0};  // that are still missing to the clearance, at the motion's beginning and end
  bool has_touched_ = false;
};

StraightMotion motionOf(const proto::FrameTransform& frame, const glm::dvec3& from, const glm::dvec3& to) {
  const proto::LatticePosition a = frame.toLattice(from), b = frame.toLattice(to);
  StraightMotion m{.from = a, .across = {b.x - a.x, b.y - a.y}, .rise_m = b.height_m - a.height_m};
  if (frame.frame().kind == proto::FrameKind::kGeographic) {
    const double turn = kTurn / frame.frame().longitude_step_rad;
    m.across.x -= turn * std::round(m.across.x / turn);
  }
  const double length_m = glm::distance(from, to);
  m.level_m = std::sqrt(std::max(0.0, length_m * length_m - m.rise_m * m.rise_m));
  return m;
}

}  // namespace

glm::dvec3 sweep(const GroundHeights& ground, const proto::FrameTransform& frame, const glm::dvec3& from,
                 const glm::dvec3& to, double clearance_m) {
  if (from == to) return from;
  const double pieces = std::max(1.0, std::ceil(glm::distance(from, to) / kLongestPiece_m));
  Glide glide(ground, clearance_m);
  proto::LatticePosition at = frame.toLattice(from);
  for (double i = 0; i < pieces; ++i) {
    const glm::dvec3 step = to - from;
    StraightMotion motion = motionOf(frame, from + step * (i / pieces), from + step * ((i + 1) / pieces));
    motion.from = at;
    at = glide.run(motion);
  }
  return glide.hasTouched() ? frame.toScene(at) : to;
}

}  // namespace foreland::client
