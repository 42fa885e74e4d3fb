// How many nodes of a section would be left if visibility were known exactly, and how many as more and more of what a
// real visibility cannot do without is added: the reasons why a server leaves out less. By lines of sight to samples of
// the full resolution (oracle/line_of_sight.h).
#pragma once

#include <vector>

#include "oracle/line_of_sight.h"
#include "proto/space/view.h"
#include "server/section/hierarchy.h"

namespace foreland::lab {

// Nodes, each line with all that the one before it has. All but the first two with their ancestors.
struct PossibleNodes {
  double all = 0;       // of the section
  double visible = 0;   // whose vertex is visible from the eye
  double vertices = 0;  // the same
  double raised = 0;    // whose vertex is visible from the eye if raised by the tolerance
  double supports = 0;  // where a sample so raised is visible in the supports of the node and its descendants
  double blocks = 0;  // where one is visible in a block that those supports meet (proto/refine/hidden/hidden_blocks.h)
  double region = 0;  // the same from the eyes of the keyframes before and after, too

  void add(const PossibleNodes& other);
};

// Which samples of the terrain are visible from any of some eyes; nothing outside of a cone about the view. O(samples)
// to make, with a line of sight each; O(1) to ask. Uses all processors.
class VisibleSamples {
 public:
  explicit VisibleSamples(const oracle::LineOfSight& terrain);

  // Samples count as standing higher by as many metres as `raised_px` pixels are at their distance.
  void see(const proto::Pose& pose, const proto::Lens& lens, double raised_px);
  // After the last see(), and before the first question.
  void sum();

  // Whether one in the rectangle, borders included, is visible. It may extend beyond the data.
  bool any(int64_t low_x, int64_t low_y, int64_t high_x, int64_t high_y) const;

 private:
  uint32_t upTo(int64_t x, int64_t y) const;  // those below x and y

  const oracle::LineOfSight& terrain_;
  std::vector<uint8_t> is_visible_;
  std::vector<uint32_t> sums_;  // of rectangles from the first sample
};

struct EyesOfKeyframe {
  proto::Pose now, before, after;
};

class PossibleJudge {
 public:
  // Both must outlive it.
  PossibleJudge(const server::Hierarchy& hierarchy, const oracle::LineOfSight& terrain)
      : hierarchy_(hierarchy), terrain_(terrain) {}

  // `slots` is a section for a tolerance of `tau_px`.
  PossibleNodes count(const std::vector<proto::Slot>& slots, const EyesOfKeyframe& eyes, const proto::Lens& lens,
                      double tau_px) const;

  // Those of the nodes whose vertex, raised by a tolerance, can be seen from the eye, in whatever direction the camera
  // looks. Uses all processors.
  std::vector<proto::Slot> visible(const std::vector<proto::Slot>& slots, const glm::dvec3& eye,
                                   const proto::Lens& lens, double raised_px) const;

  glm::dvec3 vertex(proto::Slot slot) const;

 private:
  const proto::GridTopology& grid() const { return hierarchy_.grid(); }
  double withAncestors(const std::vector<proto::Slot>& slots) const;

  const server::Hierarchy& hierarchy_;
  const oracle::LineOfSight& terrain_;
};

}  // namespace foreland::lab
