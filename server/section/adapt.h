// From the previous section to the next at a cost that follows the changes. Only the frontier (removable and addable
// nodes) can change, and a frontier node's test only once the camera has moved far enough: each entry carries its
// slack, the motion that its outcome is sure to survive (Metric::outcome). A step takes its toll off every slack in one
// pass over flat arrays, and tests again only where it is used up. Equal to refine(), node for node, for any motion.
//
// S 3.4 moves the cut by testing all of it; the slack is ours.
//
// One owner (a session). No allocation once grown to the session's size. Memory: 12 bytes a frontier entry and about 2
// a node.
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
  std::vector<uint32_t> due;         // entries
  std::vector<proto::Slot> changed;  // whose neighbours have not been looked at yet
  std::vector<uint32_t> left;        // entries to drop
};

class Adapter {
 public:
  explicit Adapter(const Hierarchy& hierarchy) : hierarchy_(&hierarchy) {}

  // Moves to the section of `view` and appends what changed to `delta`, in no order. False if the section would exceed
  // `max_nodes`: it is then closed, but not yet the view's; call again with a larger tolerance.
  [[nodiscard]] bool adapt(const View& view, size_t max_nodes, AdaptScratch& scratch, proto::CutDelta& delta);

  size_t nodeCount() const { return active_; }
  proto::Section section() const;  // ascending; for tests and tools
  bool contains(proto::NodeId n) const { return flags_.get(NodeFlags::kActive, hierarchy_->grid().slot(n)); }
  bool contains(proto::Slot slot) const { return flags_.get(NodeFlags::kActive, slot); }
  size_t bytes() const;  // of this session's state
  size_t frontierSize() const { return slots_.size(); }
  uint64_t testCount() const { return tests_; }  // since the start
  // CHECKs that the section is closed and that exactly the nodes of its frontier have an entry that has not left.
  // O(scene); for tests.
  void validate() const;

 private:
  template <class Places>
  class Step;
  Metric::Toll tollTo(const View& view) const;

  const Hierarchy* hierarchy_;
  NodeFlags flags_;
  // Frontier entries, a column each. An entry says what its node is (active: passes) and how long that is sure to hold.
  // Nodes that have left the frontier keep theirs for a while; it stays true, so it does no harm.
  std::vector<proto::Slot> slots_;
  std::vector<float> slack_;  // what is left of it (Metric::Outcome), metres
  std::vector<uint32_t>
      reach_;  // largest distance from the eye meanwhile, metres, as a float whose last two bits are the guard
  std::optional<View> last_;
  size_t active_ = 0;
  size_t sweep_ = 0;  // entry at which the search for those that have left goes on
  uint64_t tests_ = 0;
  uint32_t steps_ = 0;
};

// Sorts a delta gathered over several calls and drops what came and went.
void settle(proto::CutDelta& delta);

}  // namespace foreland::server
