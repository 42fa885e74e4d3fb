// Where a terrain adapter's heights and decisions come from (adapter.h): the scene's records, an encoder that writes
// what it sends, or a decoder that reads it (codec/delta_codec.h). Control is inverted: the adapter's step calls the
// source for what it needs next, and which calls it makes in which order follows from the section and the views alone,
// so both ends make the same calls. One owner; called during one step only.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "proto/refine/hidden/hidden_blocks.h"
#include "proto/refine/terrain_batch.h"
#include "proto/section/bounds.h"
#include "proto/section/node_tables.h"

namespace foreland::proto {

// What is known of how a decision about an addable node will turn out, from what was said of its page and its parents
// before the step.
enum class ClientKnowledge : uint8_t {
  kNew,       // one of its parents was not known, so it was not on the frontier before
  kSeen,      // it may have been, but no node of its page was asked about this closely
  kRejected,  // it is not known though its page was asked about at least this closely
  kKnown,     // it is known, but its page was asked about more closely
};

// Is the error of a node at least `least`? Earlier decisions leave this open; either the node is in the section, its
// error at least `bound`, and `least` is more; or it is not, its error at most `bound`, and `least` is no more.
struct Predicate {
  Slot slot = 0;
  QuantisedError bound, least;
  bool is_in_section = false;
  bool is_new = false;    // the node has come to the frontier in this step
  bool is_known = false;  // its height was sent
  ClientKnowledge client_knowledge = ClientKnowledge::kNew;
  QuantisedError finest{255};  // the least error that a node of the page was asked about
};

class TerrainSource {
 public:
  virtual ~TerrainSource() = default;
  // Whether a page of a sparse level is there that was empty so far; `first` is the first of its nodes to be tested. If
  // it is not, these nodes do not come to the frontier. Asked each time before the radius.
  virtual bool hasPage(Slot /*first*/) { return true; }
  // The radius of all nodes of a page that was empty so far; `first` is the first of them to be tested.
  virtual QuantisedRadius radius(Slot first) = 0;
  // Tells of nodes of a level that have come to the frontier and are not known, ascending; before anything else is
  // asked of them.
  virtual void onAddable(int, std::span<const Slot>) {}
  // Fills in the heights of the batch's spheres, and the errors of settled nodes.
  virtual void load(TerrainBatch& batch) = 0;
  // Decides predicates about nodes of one level, ascending: 1 for true. False stops the step.
  virtual bool decide(int level, std::span<const Predicate> predicates, std::span<uint8_t> decisions) = 0;
  // Tells of nodes that were not known and are added; their predicates have just been decided to be true. False stops
  // the step.
  virtual bool onAdded(int /*level*/, std::span<const Predicate>) { return true; }
  // Tells that decisions leave but this error for a known node.
  virtual void onSettled(Slot, QuantisedError) {}
  // Before anything else in a step: whether nodes of hidden blocks are left out of the section, and which of the blocks
  // that are known (`blocks`) are hidden that were not, or the other way round, appended to `changed`. False stops the
  // step. A source that hides nothing leaves both alone.
  virtual bool reviseBlocks(const HiddenBlocks&, bool& /*hides*/, std::vector<BlockId>& /*changed*/) { return true; }
  // Whether a block that was unknown is hidden; asked only if this step leaves hidden nodes out.
  virtual bool isHidden(const HiddenBlocks&, const BlockId&) { return false; }
};

// A scene's records, without a wire.
class InMemoryNodes final : public TerrainSource {
 public:
  explicit InMemoryNodes(const StoredNodes& nodes) : nodes_(nodes) {}
  bool hasPage(Slot first) override { return nodes_.hasPage(first); }
  QuantisedRadius radius(Slot first) override { return nodes_[first].radius(); }
  void load(TerrainBatch& batch) override {
    for (size_t i = 0; i < batch.count; ++i) batch.setRecord(i, nodes_[batch.slot[i]]);
  }
  bool decide(int, std::span<const Predicate> predicates, std::span<uint8_t> decisions) override {
    for (size_t i = 0; i < predicates.size(); ++i)
      decisions[i] = nodes_[predicates[i].slot].error() >= predicates[i].least ? 1 : 0;
    return true;
  }

 private:
  StoredNodes nodes_;
};

}  // namespace foreland::proto
