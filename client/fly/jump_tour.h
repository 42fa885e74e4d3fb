// A flight that jumps from view to view, as people do who choose landmarks or open shared links: every kEvery the
// camera is elsewhere at once, 1, 3, 12 or 48 km or half the scene away, and looks elsewhere; between jumps it flies on
// slowly. Over a globe, where it begins in the middle of the north, it also jumps 1,000 km and to the other side. It
// measures how a viewer comes back to its tolerance. The tour is no path: no camera ever was between two views. Plans
// and reports are values; any thread.
#pragma once

#include <array>
#include <cmath>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "client/viewer.h"
#include "proto/space/frame.h"
#include "proto/space/pose.h"
#include "proto/topology/grid.h"

namespace foreland::client {

class JumpTour {
 public:
  static constexpr Duration kEvery = Duration::seconds(4);
  static constexpr double kSpeed_mps = 50, kAboveGround_m = 300;

  // One that lasts at least `seconds`, over as many kinds of jumps as the scene has room for; an Error if it has room
  // for none.
  static Result<JumpTour> plan(const proto::FrameTransform& frame, const proto::GridShape& shape, double seconds);

  // The lattice positions whose heights setGround() takes, in their order.
  const std::vector<glm::dvec2>& positions() const { return positions_; }
  // Places the views above the ground. NaN is taken for 0.
  void setGround(std::span<const float> heights_m);

  size_t views() const { return views_.size(); }
  Duration length() const { return kEvery * static_cast<int64_t>(views_.size()); }
  // Which view is flown at a time since the start, and what kind of jump leads to it; empty for the first.
  size_t viewAt(Duration t) const;
  const std::string& kindOf(size_t view) const { return views_[view].kind; }
  proto::Pose at(Duration t) const;

 private:
  static constexpr size_t kSamples = 5;  // of the ground along a view's flight
  struct View {
    std::string kind;
    glm::dvec3 eye;  // scene frame; raised by setGround()
    double heading_rad;
    // Headings turn from east to north.
    glm::dvec3 east{1, 0, 0}, north{0, 1, 0}, up{0, 0, 1};

    glm::dvec3 along() const { return std::cos(heading_rad) * east + std::sin(heading_rad) * north; }
  };

  void jumpOverData(const proto::GridShape& shape, size_t wanted);
  void jumpOverGlobe(size_t wanted);
  View viewOverGlobe(std::string kind, const glm::dvec3& direction, double heading_rad) const;
  void placeSamples();

  explicit JumpTour(const proto::FrameTransform& frame) : frame_(frame) {}

  proto::FrameTransform frame_;
  std::vector<View> views_;
  std::vector<glm::dvec2> positions_;
};

// What came of the jumps of one kind.
struct JumpReport {
  std::string kind{};
  uint32_t jumps = 0, recovered = 0;  // how many there were, and after how many the wanted tolerance was held again
  // From the jump to the first frame at the wanted tolerance; about kEvery if there is none.
  Duration worst_recovery{}, mean_recovery{};
  Duration worst_without{};         // from the jump to the first frame that guarantees any tolerance
  float largest_tolerance_px = 0;   // of what was guaranteed on the way
  uint32_t late_coarse_frames = 0;  // after kFirstPicture: above kCoarse_px, or without any guarantee
};

class JumpReports {
 public:
  static constexpr Duration kFirstPicture = Duration::milliseconds(400);
  static constexpr float kCoarse_px = 8;

  // Counts a frame of view `view`, `since_jump` after the jump to it. `wanted_px` is the tolerance that is asked for.
  // The first view is no jump's and is not counted.
  void count(const JumpTour& tour, size_t view, Duration since_jump, bool shows_view, float tolerance_px,
             double wanted_px);
  const std::vector<JumpReport>& reports() const { return reports_; }

 private:
  std::vector<JumpReport> reports_;
  size_t view_ = 0;
  bool is_guaranteed_ = false, is_recovered_ = false;
};

}  // namespace foreland::client
