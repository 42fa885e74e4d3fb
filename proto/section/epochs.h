// Scenes that change in time (P section 5): key geometries over one grid, each the ground at one time, an *epoch*. At
// any *scene time* the ground is a blend of epochs, height by height. What lies below says which epochs, with which
// weights, and what both ends know of the heights at them.
//
// Heights at an epoch are stored and sent as *offsets*: the height there minus the height at the first epoch, in
// quanta. An epoch's offsets are zero outside of its window. Errors and radii of nodes (bounds.h) hold for all scene
// times, so a section does not depend on the scene time: only the heights of its nodes do.
//
// Immutable after creation; any thread; portable to WebAssembly.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "proto/section/bounds.h"
#include "proto/topology/grid.h"

namespace foreland::proto {

// Samples of the lattice, from the south-west one on.
struct LatticeWindow {
  uint32_t x = 0, y = 0, width = 0, height = 0;

  bool isEmpty() const { return width == 0 || height == 0; }
  bool contains(uint32_t at_x, uint32_t at_y) const { return at_x - x < width && at_y - y < height; }
  // The smallest window that holds both.
  static LatticeWindow hull(const LatticeWindow& a, const LatticeWindow& b);
  // What is in both.
  static LatticeWindow common(const LatticeWindow& a, const LatticeWindow& b);
  bool operator==(const LatticeWindow&) const = default;
};

// Largest offset, quanta either way: a difference of two heights.
inline constexpr int32_t kMaxOffset = 2 * kMaxHeight;

struct Epoch {
  Time time;            // since 1970, UTC
  LatticeWindow moved;  // where offsets may differ from zero
  bool operator==(const Epoch&) const = default;
};

// The offset of a base vertex, which no delta carries. Vertices are numbered as corner heights, then centre heights, of
// the welcome.
struct BaseOffset {
  uint32_t epoch = 0, vertex = 0;
  int32_t quanta = 0;
  bool operator==(const BaseOffset&) const = default;
};
// By epoch and vertex, as baseOffsetAt() takes them.
void sortBaseOffsets(std::vector<BaseOffset>& offsets);
// The offset of a base vertex; 0 if it is not among them. O(log n).
int32_t baseOffsetAt(std::span<const BaseOffset> sorted, uint32_t epoch, uint32_t vertex);
// The number of a base vertex in a BaseOffset.
uint32_t baseVertexNumber(const GridTopology& grid, NodeId base);
// The base vertex of a number.
NodeId baseVertex(const GridTopology& grid, uint32_t number);

// How the ground between epochs follows from theirs: a property of a scene. With t the dates and e the heights at them,
//
//   linear       straight from each epoch to the next; the motion's speed jumps at every date
//   Catmull-Rom  through every epoch, with a speed that does not jump: cubic from t_i to t_i+1 (Hermite's), with the
//                speed (e_i+1 - e_i-1) / (t_i+1 - t_i-1) at t_i, and at the first and last date that of the only
//                neighbour's difference. May overshoot: weights outside of [t_i, t_i+1] are negative
//   B-spline     the cubic B-spline whose knots are the dates, the first and the last four times, and whose control
//                heights are the epochs', the first and the last twice. Begins at the first epoch and ends at the last,
//                at rest, passes near the others; no weight is negative, and neither speed nor acceleration jumps
//
// Numbers as in scene files and in the welcome.
enum class EpochBlend : uint8_t { kLinear, kCatmullRom, kBSpline };
inline constexpr std::array<std::string_view, 3> kEpochBlendNames{"linear", "catmull-rom", "b-spline"};
// Of any number; nothing if it is none's.
std::optional<EpochBlend> epochBlendOf(uint32_t number);
inline std::string_view name(EpochBlend blend) { return kEpochBlendNames[static_cast<size_t>(blend)]; }

// Ground that does not move linearly moves nearly so from one keyframe to the next: as far as it does not, it takes
// this share of the tolerance that frames keep, and sections are refined to the rest.
inline constexpr double kMotionShare = 0.25;
// To which a section is refined for frames to keep `tau_px`.
inline double sectionTolerance(EpochBlend blend, double tau_px) {
  return blend == EpochBlend::kLinear ? tau_px : (1 - kMotionShare) * tau_px;
}
// Which frames keep between sections that are refined to `section_px`.
inline double frameTolerance(EpochBlend blend, double section_px) {
  return blend == EpochBlend::kLinear ? section_px : section_px / (1 - kMotionShare);
}

// The epochs whose blend is the ground at a scene time, ascending; weights add to 1.
struct EpochWeights {
  std::array<uint32_t, 4> epoch{};
  std::array<double, 4> weight{1, 0, 0, 0};
  uint32_t count = 1;

  std::span<const uint32_t> epochs() const { return std::span(epoch).first(count); }
  bool operator==(const EpochWeights&) const = default;
};

// A cubic blend from one epoch to the next as a Bezier curve: with u from 0 to 1, heights are the sum of Bernstein's
// polynomials (1-u)^3, 3 u (1-u)^2, 3 u^2 (1-u), u^3 times four control heights, which are blends of epochs
// themselves. So heights lie between the control heights, and errors are no larger than the largest of the four grounds
// that these make.
struct EpochCurve {
  uint32_t first = 0, count = 0;                    // the epochs blended: `count` from `first` on
  std::array<std::array<double, 4>, 4> controls{};  // weights of these epochs, by control height

  // Weights of the epochs' heights in the acceleration at either end, by u. It is linear between.
  std::array<std::array<double, 4>, 2> accelerations() const;
};

class Epochs {
 public:
  static constexpr size_t kMax = 1024;
  static constexpr int64_t kMaxTime_us = int64_t{1} << 61;  // either way; 73,000 years

  // Of a scene that does not change.
  Epochs() = default;
  // An Error names the first epoch that is out of order, or whose window reaches beyond the data. The first one's is
  // empty.
  static Result<Epochs> create(const GridShape& shape, std::vector<Epoch> epochs,
                               EpochBlend blend = EpochBlend::kLinear);

  bool empty() const { return epochs_.empty(); }
  size_t size() const { return epochs_.size(); }
  const Epoch& operator[](size_t i) const { return epochs_[i]; }
  std::span<const Epoch> all() const { return epochs_; }
  EpochBlend blend() const { return blend_; }
  // Not of a scene that does not change, like all below.
  Time first() const { return epochs_.front().time; }
  Time last() const { return epochs_.back().time; }
  Time clamp(double us) const;

  // O(log epochs).
  EpochWeights weightsAt(Time scene_time) const;
  // Of a cubic blend, from an epoch to the next; not of the last epoch. O(1).
  EpochCurve curveAfter(uint32_t epoch) const;
  // Two numbers that hold a quantity at all scene times, which has `values` at the epochs: the least and the largest of
  // the values and, of Catmull-Rom, of the control heights. O(epochs).
  std::array<double, 2> range(std::span<const int32_t> values) const;
  // The scene time nearest to `wanted` such that between `from` and it there is no epoch, so linearly blended ground
  // moves linearly from the one to the other.
  Time towards(Time from, Time wanted) const;

  // Whether the vertex's offset at the epoch may differ from zero. Beyond the data heights are those of the nearest
  // sample.
  bool mayMove(uint32_t epoch, NodeId v) const {
    return epochs_[epoch].moved.contains(std::min(v.x(), last_x_), std::min(v.y(), last_y_));
  }

 private:
  // The date of an epoch, of the nearest one beyond the ends; seconds since the first.
  double date(int64_t epoch) const;
  EpochCurve neighbours(uint32_t epoch) const;
  EpochCurve catmullRom(uint32_t epoch) const;
  EpochCurve bSpline(uint32_t epoch) const;

  std::vector<Epoch> epochs_;
  EpochBlend blend_ = EpochBlend::kLinear;
  uint32_t last_x_ = 0, last_y_ = 0;  // of the data
};

// The offsets of a scene's nodes, as its owner has them. Any thread.
class OffsetSource {
 public:
  virtual ~OffsetSource() = default;
  // Quanta; at most kMaxOffset either way.
  virtual int32_t offset(uint32_t epoch, Slot slot) const = 0;
};

// How scene time goes: it is `scene_time` until the client's time `at`, and goes on from there at `rate` scene seconds
// a second.
struct SceneClock {
  static constexpr double kMaxRate = 1e12;

  Time at;
  Time scene_time;
  double rate = 0;

  // Within the epochs.
  Time timeAt(const Epochs& epochs, Time t) const;
  bool operator==(const SceneClock&) const = default;
};

}  // namespace foreland::proto
