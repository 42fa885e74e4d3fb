// From the previous section to the next at a cost that follows the changes. Only the frontier (removable and addable
// nodes) can change, and a frontier node's test only once the camera has moved far enough: each entry carries its
// slack, the motion that its outcome is sure to survive (Metric::outcome). A step takes its motion off every slack,
// page by page, and tests again only where it is used up. Equal to refine(), node for node, for any motion.
//
// S 3.4 moves the cut by testing all of it; the slack is ours.
//
// Both ends run it: the server on the scene's records, the client on what it is sent. Neither needs to know a node's
// error: an entry has a bound on it, from below for a node of the section, from above for one that can be added. Only
// where that does not settle the test is there a question, "is the error at least the least that passes?", and its
// answer becomes the entry's bound. So the answers, in the order of the questions, are all that a client must be told
// of what comes and what goes (delta_codec.h). A node that leaves the frontier is forgotten: what is known is a matter
// of the section and of the views since.
//
// Terrain and surfaces share it: a Batch says how nodes are tested (terrain_batch.h, surface_batch.h), its Domain how
// they are named. A surface's records settle every test, so of it no questions are asked.
//
// One owner (a session, a replica). No allocation once grown to the section's size.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "proto/refine/frontier.h"
#include "proto/section/section.h"

namespace foreland::proto {

// Is the error of a node at least of class `least`? One of these is true: it is at least `known` (and `least` is more,
// and the node is in the section), or at most `known` (and `least` is no more, and the node is not).
struct Predicate {
  Slot slot = 0;
  QuantisedError known, least;
  bool is_in_section = false;
  bool is_new = false;  // the node has come to the frontier in this step
};

// Where an adapter's records and answers come from. Of either end; called during one step only. The order of calls and
// of what they are asked is a matter of the section and the view.
template <class Batch>
class NodeSource {
 public:
  virtual ~NodeSource() = default;
  // Of all nodes of a page none of which is known; `first` is to be known first.
  virtual QuantisedRadius radius(Slot first) = 0;
  // Nodes of a level that have come to the frontier, ascending; before anything else is asked of them.
  virtual void onAddable(int, std::span<const Slot>) {}
  // Fills in what the batch's tests take: the heights of spheres, or records.
  virtual void load(Batch& batch) = 0;
  // Questions about nodes of one level, ascending. False stops the step.
  virtual bool decide(int level, std::span<const Predicate> predicates, std::span<uint8_t> decisions) = 0;
  // Nodes of one level that come to the section, ascending, and the least class that each passed with. False stops.
  virtual bool onAdded(int, std::span<const Slot>, std::span<const QuantisedError>) { return true; }
};

// A worker's own; reused from call to call.
struct AdaptScratch {
  struct Candidate {
    Predicate predicate;
    uint32_t page;
  };
  // Nodes whose test is open, or that may have come to the frontier; by page.
  std::vector<SlotBits> undecided;
  std::vector<uint8_t> has_undecided;
  std::vector<Slot> seeds, pending;  // the same on pages that are not there: of any level, of the next one
  std::vector<Slot> pages;           // of each such page the first of them
  std::vector<Candidate> candidates;
  std::vector<uint32_t> asked;  // of a batch: those in question
  std::vector<Predicate> predicates;
  std::vector<uint8_t> decisions;
  std::vector<Slot> slots;
  std::vector<QuantisedError> passed;
};

template <class Batch>
class Adapter {
 public:
  using Domain = typename Batch::Domain;

  // Begins with the empty section.
  explicit Adapter(const Domain& domain) : domain_(&domain) {}
  // Begins with a closed section, of whose nodes nothing is known but that they are there. The source tells the radii
  // of its pages. On both ends the same.
  Adapter(const Domain& domain, std::span<const Slot> section, NodeSource<Batch>& source);

  // Moves to the section of `view` and appends what changed to `delta`, ascending. False if the section would exceed
  // `max_nodes` or the source stopped: the adapter is then of no more use.
  [[nodiscard]] bool adapt(const View& view, size_t max_nodes, NodeSource<Batch>& source, AdaptScratch& scratch,
                           CutDelta& delta);

  size_t nodeCount() const { return nodes_in_section_; }
  Section section() const;  // ascending
  bool contains(Slot slot) const { return frontier_.isInSection(slot); }
  // Of the page of a node of the section.
  QuantisedRadius radius(Slot slot) const { return frontier_.radius(slot); }
  // Whether any of the 64 slots from `first` on, a multiple of 64, is of the section or its frontier.
  bool knowsBlock(Slot first) const { return frontier_.hasAnyOf64(first); }
  size_t bytes() const { return frontier_.bytes(); }  // of this session's state
  size_t frontierSize() const { return frontier_.entryCount(); }
  uint64_t testCount() const { return tests_; }  // since the start
  // CHECKs that the section is closed and that exactly the nodes of its frontier have an entry. O(scene); for tests.
  void validate() const;

 private:
  class Step;
  MotionBound motionBoundTo(const View& view) const;

  const Domain* domain_;
  Frontier frontier_;
  std::optional<View> last_;
  bool has_seeds_ = false;  // the nodes without parents are on the frontier
  size_t nodes_in_section_ = 0;
  uint64_t tests_ = 0;
  uint32_t steps_ = 0;
};

}  // namespace foreland::proto
