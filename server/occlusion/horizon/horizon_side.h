// One of the four sides of a horizon (horizon.h): what the lines of the grid that cross its directions hide. One owner.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "server/occlusion/horizon/horizon_grid.h"
#include "server/occlusion/horizon/horizon_line.h"
#include "server/view/eye_capsule.h"

namespace foreland::server {

// The eyes of a horizon, in steps of the grid and, upward, metres.
struct HorizonEyes {
  glm::dvec2 begin{0}, way{0};
  double ball = 0;
  double highest_m = 0;
};

class HorizonSide {
 public:
  static constexpr double kMaxTangent = 1.25;  // squares across a diagonal belong to one side
  static constexpr uint32_t kNearest = 2;      // steps ahead, of what may be hidden
  // Of bins, so that a side has at most 128 segments: 3 pixels of a lens of 9800 pixels' focal length.
  static constexpr double kMinBin = 2 * kMaxTangent / (128 * HorizonLine::kBins);

  // Ahead is along +x, +y, -x or -y: side 0 to 3. Forgets all that was found for other eyes.
  void look(const HorizonGrid& grid, const HorizonEyes& eyes, uint32_t number, double bin);
  void forget() { bin_ = 0; }
  bool isMade() const { return bin_ > 0; }

  // Of a position or a vector of the grid: ahead and aside, from the origin of the grid.
  glm::dvec2 turned(const glm::dvec2& v) const { return {sign_ * (is_x_ ? v.x : v.y), is_x_ ? v.y : v.x}; }
  const glm::dvec2& reference() const { return reference_; }  // turned

  // Bins of directions with tangents from -kMaxTangent to kMaxTangent.
  uint32_t binOf(double tangent) const { return static_cast<uint32_t>((tangent + kMaxTangent) / bin_); }
  uint32_t binCount() const { return static_cast<uint32_t>(segments_.size()) * kBins; }
  double tangentOf(uint32_t bin) const { return bin * bin_ - kMaxTangent; }

  // Below it nothing is hidden.
  static constexpr double kMinSlope = std::numeric_limits<int16_t>::min() + 1;
  // What the slope of a point in a bin is less than, times slopesOfStep(), if the point is hidden from all eyes;
  // `ahead` is its distance, at least kNearest.
  int slope(uint32_t bin, double ahead);
  float slopesOfStep() const { return slopes_of_step_; }  // in a metre per step

  uint64_t segmentsBuilt() const { return built_; }  // in part at least
  size_t bytes() const;                              // in constant time

 private:
  static constexpr uint32_t kBins = HorizonLine::kBins;
  // Built as far ahead as it was asked for.
  struct Segment {
    std::vector<int16_t> kept;          // kBins slopes for each distance
    std::array<float, kBins> slopes{};  // of the lines so far; in metres per step
    uint32_t lines = 0;
    bool is_whole = false;  // what is farther away hides nothing more
    size_t distances() const { return kept.size() / kBins; }
  };
  // A line of the grid on some level; `ahead` of the reference, in steps of the finest level.
  struct Line {
    uint32_t level, number;
    float ahead;
  };
  // How far beside its own line to a point an eye's may pass, steps, and the tangents of a segment.
  struct Reach {
    double first, last, low, high;
  };

  void findLines();
  Reach reachOf(uint32_t segment) const;
  // Where a line is cut by the borders of a segment's bins, and how many bins more count for each; not if these were
  // too many, for the line is so near.
  struct Cut {
    HorizonLine::Vertices vertices;
    float first, step;
    int halo;
    bool isNear() const { return halo > HorizonLine::kMaxHalo; }
  };
  Cut cutOf(const Line& line, const Reach& reach) const;
  void build(uint32_t number, size_t distance);
  void keep(Segment& segment);
  bool isClosed(const std::array<float, kBins>& slopes, float ahead) const;

  const HorizonGrid* grid_ = nullptr;
  bool is_x_ = false;                  // ahead is along x
  double sign_ = 1;                    // -1 if it is to smaller coordinates
  HorizonGrid::Along along_{};         // the direction of the lines
  glm::dvec2 reference_{0}, back_{0};  // and from there to the capsule's farther end
  double depth_ = 0, ball_ = 0;        // steps
  double eye_m_ = 0, bin_ = 0;
  float slopes_of_step_ = 1;
  std::vector<Line> lines_;  // by distance
  std::vector<Segment> segments_;
  uint64_t built_ = 0;
  size_t kept_bytes_ = 0;  // of all segments
};

}  // namespace foreland::server
