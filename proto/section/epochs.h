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

// The epochs whose blend is the ground at a scene time; weights are positive and add to 1.
struct EpochWeights {
  std::array<uint32_t, 2> epoch{};
  std::array<double, 2> weight{1, 0};
  uint32_t count = 1;

  std::span<const uint32_t> epochs() const { return std::span(epoch).first(count); }
  bool operator==(const EpochWeights&) const = default;
};

class Epochs {
 public:
  static constexpr size_t kMost = 1024;
  static constexpr int64_t kMostTime_us = int64_t{1} << 61;  // either way; 73,000 years

  // Of a scene that does not change.
  Epochs() = default;
  // An Error names the first epoch that is out of order, or whose window reaches beyond the data. The first one's is
  // empty.
  static Result<Epochs> create(const GridShape& shape, std::vector<Epoch> epochs);

  bool empty() const { return epochs_.empty(); }
  size_t size() const { return epochs_.size(); }
  const Epoch& operator[](size_t i) const { return epochs_[i]; }
  std::span<const Epoch> all() const { return epochs_; }
  // Not of a scene that does not change, like all below.
  Time first() const { return epochs_.front().time; }
  Time last() const { return epochs_.back().time; }
  Time clamp(double us) const;

  // Linear between neighbouring epochs. O(log epochs).
  EpochWeights weightsAt(Time scene_time) const;
  // The scene time nearest to `wanted` such that between `from` and it there is no epoch, so the ground moves linearly
  // from the one to the other.
  Time towards(Time from, Time wanted) const;

  // Whether the vertex's offset at the epoch may differ from zero. Beyond the data heights are those of the nearest
  // sample.
  bool mayMove(uint32_t epoch, NodeId v) const {
    return epochs_[epoch].moved.contains(std::min(v.x(), last_x_), std::min(v.y(), last_y_));
  }

 private:
  std::vector<Epoch> epochs_;
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
  static constexpr double kMostRate = 1e12;

  Time at;
  Time scene_time;
  double rate = 0;

  // Within the epochs.
  Time timeAt(const Epochs& epochs, Time t) const;
  bool operator==(const SceneClock&) const = default;
};

}  // namespace foreland::proto
