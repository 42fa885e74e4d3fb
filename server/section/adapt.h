// From the previous section to the next at a cost that follows the changes. Only the frontier (removable and addable nodes) can change,
// and a frontier node's test only once the camera has moved far enough: each entry carries its slack, the motion in
// view coordinates that its outcome is sure to survive (Metric::slack). A step takes the motion off every slack in one
// pass over flat arrays, and tests again only where it is used up. Equal to refine(), node for node, for any motion.
//
// S 3.4 moves the cut by testing all of it; the slack is ours.
//
// One owner (a session). No allocation once grown to the session's size. Memory: 12 bytes a frontier entry and about 2 a node.
#pragma once

#include <optional>
#include <vector>

#include "proto/section.h"
#include "server/section/hierarchy.h"
#include "server/section/metric.h"
#include "server/section/node_flags.h"

namespace foreland::server {

// A worker's own; reused from call to call.
struct AdaptScratch {
  std::vector<uint32_t> due;           // entries
  std::vector<proto::Slot> changed;    // whose neighbours have not been looked at yet
  std::vector<uint32_t> left;          // entries whose node seems to have left the frontier
  std::vector<proto::Slot> returning;  // their slots
};

class Adapter {
 public:
  explicit Adapter(const Hierarchy& hierarchy) : hierarchy_(&hierarchy) {}

  // Moves to the section of `view` and appends what changed to `delta`, in no order. False if the section would exceed
  // `max_nodes`: it is then closed, but not yet the view's; call again with a larger tolerance.
  [[nodiscard]] bool adapt(const View& view, size_t max_nodes, AdaptScratch& scratch, proto::CutDelta& delta);

  size_t nodeCount() const { return active_; }
  proto::Section section() const;  // ascending; for tests and tools
  bool contains(proto::NodeId n) const { return flags_.active(hierarchy_->grid().slot(n)); }
  size_t bytes() const;            // of this session's state
  size_t frontierSize() const { return slots_.size(); }
  uint64_t testCount() const { return tests_; }  // since the start

 private:
  template <class Places>
  class Step;
  float motionSince(const View& view, float& per_metre) const;

  const Hierarchy* hierarchy_;
  NodeFlags flags_;
  // Frontier entries, a column each. An entry says what its node is (active: passes) and how long that is sure to hold. Nodes that have
  // left the frontier keep theirs for a while; it stays true, so it does no harm.
  std::vector<proto::Slot> slots_;
  std::vector<float> slack_;  // metres of motion left
  std::vector<float> reach_;  // largest distance from the eye: a turn moves the place by angle * reach. Negative: the node passes
  std::optional<View> last_;
  size_t active_ = 0;
  size_t sweep_ = 0;  // entry at which the search for nodes that have left goes on
  uint64_t tests_ = 0;
  uint32_t steps_ = 0;
};

// Sorts a delta gathered over several calls and drops what came and went.
void settle(proto::CutDelta& delta);

}  // namespace foreland::server
