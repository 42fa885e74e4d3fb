// What can be seen over a terrain from a set of eyes: in bins of directions, how steeply a line of sight must rise to
// pass over all that lies nearer than a distance. Tests of squares then are a few comparisons. Exact in one direction:
// what is called hidden is hidden.
//
// The eyes are a ball of radius b that is swept along a segment (EyeCapsule). Everything is done in steps of a grid of
// heights (horizon_grid.h) whose four directions have a side of the horizon each; let x count the steps ahead, y those
// aside. A side's reference R lies so far ahead that all eyes are E = R + (-r, w), 0 <= r <= depth, and as high as the
// highest of them. A line of sight to a point p = (D, u D) with D > 0 crosses each line of the grid with 0 < x < D.
//
//   where    The line from E crosses it at y = u x + f (w + u r), f = (D - x) / (D + r) < 1: no farther to either side of
//            u x than an eye is from the line through R and p. So if the terrain on this line of the grid is high enough
//            between the bounds of that, for all eyes and all u of a bin, it blocks the lines of the whole bin. Between
//            neighbouring samples the terrain on a line of the grid is straight: nothing is missed between them.
//   how high Let P be the height of p over R. There the line is at most P (x + r) / (D + r) above R. If P <= 0 that is no
//            more than x P / D; otherwise no more than (x + depth) P / D. So a terrain that is H over R hides from all
//            eyes all points of the bin, farther away, for which P / D <= H / x, or for H > 0, P / D <= H / (x + depth).
//   squares  The points p fill a square below a plane: P / D - c u is largest at one of its corners, whatever c is.
//
// Over globes ground is drawn up to e = tau d / f from where it is at the distance d, to any side, not only lower.
// There the lines' heights are those of all ground within a spacing of each of their points (globe_heights.h), and
// lines of a level count as far ahead as bins are no wider than its spacing:
//
//   where it is drawn   Let q be the nearest point of the line from E at which all ground within e is e above it. It lies in the body
//                   that is drawn, or ground x drawn at y has passed q, so |x - q| > e(q): then x lies in a block that is
//                   hidden. The hull of that block, which has all that is drawn of it, has q; but lines to hidden hulls meet such a
//                   point before, which is nearer.
//   how far         Lines that hide have slopes of 45 degrees at most (block_test.cpp) and tangents of 1.75 from the eye, whose
//                   room is half of a square's distance at most: so d <= 2.85 (x + r), and e is less than a bin's width
//                   if that is three tolerances.
//
// The largest of these slopes of all lines nearer than D (of some of them: those left out hide nothing) is kept for a
// series of distances D, rounded down. A segment of 64 bins is built when it is asked for, as far ahead as that; a line
// of the grid that is so near that the eyes' lines cross too many bins of it is left out.
//
// One owner. Cost: 20 to 40 microseconds a whole segment, 90 if its heights are not in the cache, 50 ns a square.
// Memory: 20 KiB a whole segment, and 36 KiB a side before any is built, at most.
#pragma once

#include <array>
#include <cstdint>

#include "server/occlusion/horizon/horizon_grid.h"
#include "server/occlusion/horizon/horizon_side.h"
#include "server/view/eye_capsule.h"

namespace foreland::server {

class Horizon {
 public:
  // The grid must outlive it. look() comes first.
  explicit Horizon(const HorizonGrid& grid) : grid_(grid) {}

  // From these eyes from now on. `bin` is the width of a bin: the tangent of its angle ahead. Narrower ones than
  // HorizonSide::kMinBin are made so wide, for a horizon has bins all around, however little of it a lens shows.
  void look(const EyeCapsule& eyes, double bin);

  // How wide bins must be over globes for ground that is drawn so many pixels off; tolerances.
  static constexpr double kBinOfTolerance = 3;

  // A square of the lattice, in steps of the grid. All that belongs to it lies below `top_m` and below a plane: metres,
  // in the middle and from there to the sides of larger x and y.
  struct Square {
    glm::dvec2 low, high;
    double top_m;
    double height_m;
    glm::dvec2 tilt_m;
  };
  // Whether no point of it is visible from any of the eyes; false if in doubt.
  bool hides(const Square& square);

  const HorizonGrid& grid() const { return grid_; }
  const EyeCapsule& eyes() const { return eyes_; }
  double beginHeight() const { return begin_m_; }                  // of the capsule, in the grid's axes; metres
  double bin() const { return bin_; }                              // 0 before look()
  const glm::dvec2& begin() const { return eyes_in_grid_.begin; }  // of the capsule, in steps
  double extent() const { return extent_m_; }                      // of the eyes, metres
  uint64_t segmentsBuilt() const;                                  // since it was made
  size_t bytes() const;                                            // in constant time

 private:
  struct Wedge;  // of a side's directions, that a square fills

  HorizonSide& sideTowards(const Square& square);

  const HorizonGrid& grid_;
  EyeCapsule eyes_;
  HorizonEyes eyes_in_grid_;
  double bin_ = 0, extent_m_ = 0, begin_m_ = 0;
  std::array<HorizonSide, 4> sides_;
};

}  // namespace foreland::server
