// The offsets (epochs.h) of a scene's vertices that both ends of a connection know: those of base vertices from the
// start, those of nodes once they were sent. A client that resumes goes on holding offsets which the new connection's
// server does not know that it holds. One owner. A look-up is one probe of an IndexTable; memory is 272 bytes for each
// 64 slots and epoch of which anything is held.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "proto/section/epochs.h"
#include "proto/section/index_table.h"
#include "proto/topology/grid.h"

namespace foreland::proto {

class EpochOffsets {
 public:
  static constexpr Slot kBlockSlots = 64;

  // `grid` must outlive it.
  EpochOffsets(const GridTopology& grid, Epochs epochs, std::span<const BaseOffset> base);

  const Epochs& epochs() const { return epochs_; }

  // Whether a node's offset at an epoch is known; where it cannot differ from zero it is.
  bool knows(uint32_t epoch, NodeId n) const { return find(epoch, n, &Block::known).has_value(); }
  // A vertex's offset at an epoch, quanta; if it is not known, that at the nearest epoch at which it is.
  int32_t known(uint32_t epoch, NodeId v) const { return nearest(epoch, v, &Block::known).quanta; }
  // The same by what is held.
  int32_t at(uint32_t epoch, NodeId v) const { return nearest(epoch, v, &Block::held).quanta; }
  // The epoch nearest to `epoch` at which the node's offset is known; the first one's always is.
  uint32_t nearestKnown(uint32_t epoch, NodeId n) const { return nearest(epoch, n, &Block::known).epoch; }
  // A vertex's offset at a scene time by what is held, quanta.
  double at(const EpochWeights& weights, NodeId v) const;

  void set(uint32_t epoch, NodeId n, int32_t quanta);
  // No node's offset is known any more, but what is held goes on being held.
  void forget();
  // Drops the nodes' offsets.
  void clear();
  // The same of one epoch.
  void clear(uint32_t epoch);
  size_t blockCount() const;

 private:
  struct Block {
    uint64_t known = 0, held = 0;
    std::array<int32_t, kBlockSlots> quanta{};
  };
  struct Table {
    IndexTable numbers;                                 // of blocks, by slot / kBlockSlots
    std::vector<Block> blocks = std::vector<Block>(1);  // the first knows nothing
  };
  const Block& block(uint32_t epoch, Slot slot) const;
  using Bits = uint64_t Block::*;  // which of a block's offsets are known, or held
  std::optional<int32_t> find(uint32_t epoch, NodeId v, Bits bits) const;
  struct Found {
    uint32_t epoch = 0;
    int32_t quanta = 0;
  };
  Found nearest(uint32_t epoch, NodeId v, Bits bits) const;

  const GridTopology* grid_;
  Epochs epochs_;
  std::vector<BaseOffset> base_;  // by epoch and vertex
  std::vector<Table> tables_;     // by epoch
};

}  // namespace foreland::proto
