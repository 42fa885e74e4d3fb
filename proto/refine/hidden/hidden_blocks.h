// Which blocks of the terrain are hidden from the viewer, as both ends of a stream know it (the server finds out, the
// delta tells: delta_codec.h), and which nodes are hidden by that.
//
// A block of scale t is a square of the lattice with a side of 4 s, s = 2^t, aligned to its side. That it is hidden
// says that nothing can be seen of what lies in it, true or drawn with nodes of scale s and finer left out; so the
// blocks of finer scales in it are hidden, too. A node with s as the largest power of two in its coordinates is hidden
// if all blocks of its scale are that the supports of the node and its descendants meet: a square about it that reaches
// 3 s to each side for the centre of a square and 2 s for the middle of a side. A child's lies in its parent's, so if a
// node is hidden, its descendants are, and a section without hidden nodes is closed.
//
// Blocks are kept in tiles of 4 by 4. One owner; portable to WebAssembly. Memory: 4 bytes a tile that is known, in
// chunks of 64, and some 50 bytes for each of these, whatever the size of the scene.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

#include "proto/section/index_table.h"
#include "proto/space/view.h"
#include "proto/topology/grid.h"

namespace foreland::proto {

struct BlockId {
  static constexpr uint32_t kSideLog2 = 2, kSide = 1u << kSideLog2;  // in units of s

  uint8_t scale = 0;
  uint32_t x = 0, y = 0;  // of its lower corner, in sides

  BlockId parent() const { return {static_cast<uint8_t>(scale + 1), x / 2, y / 2}; }
  bool operator==(const BlockId&) const = default;
};

enum class BlockState : uint8_t { kUnknown, kVisible, kHidden };

class HiddenBlocks {
 public:
  static constexpr uint32_t kTileLog2 = 2, kTileBlocks = 1u << (2 * kTileLog2);

  // Of one tile; bit 4 y + x of its block (x, y).
  struct Tile {
    uint16_t known = 0, hidden = 0;
  };

  // `grid` must outlive it. All blocks are unknown.
  explicit HiddenBlocks(const GridTopology& grid);

  // What is known of a block by itself or by a coarser one that holds it. O(scales) at most.
  BlockState state(const BlockId& block) const;
  // The same for any block; those outside of the grid are unknown.
  BlockState stateInside(const BlockId& block) const;
  // Of a block of which no coarser one is known to be hidden. Finer blocks of one that is hidden are forgotten.
  void set(const BlockId& block, bool is_hidden);

  // Whether a node is hidden. `ask(BlockId)` says whether a block is hidden that is unknown; what it says is kept. It
  // is not asked of a block that holds a finer one which is known to be visible: such a block is visible, too.
  template <class Ask>
  bool isHidden(NodeId n, const Ask& ask);
  // The same with unknown blocks taken to be visible.
  bool isKnownHidden(NodeId n) const;

  // Calls visit(BlockId of the lowest block, const Tile&) for each tile with blocks that are known by themselves,
  // ascending by scale, then row by row.
  template <class Visit>
  void forEachTile(const Visit& visit) const;
  // Forgets the tiles for which keep(BlockId of the lowest block) is false.
  template <class Keep>
  void retainTiles(const Keep& keep);

  void clear();
  bool empty() const { return known_ == 0; }
  size_t knownCount() const { return known_; }
  size_t bytes() const;

 private:
  static constexpr uint32_t kChunkLog2 = 6, kChunkTiles = 1u << kChunkLog2;
  struct Scale {
    uint32_t tiles_x, tiles_y;
    uint64_t first_chunk;  // key of the first
    uint32_t known = 0;    // blocks
  };
  struct ChunkName {
    uint64_t key;
    uint32_t number;
  };
  // The blocks of a node's scale that its square meets: from (x0, y0) to (x1, y1), both included.
  struct Range {
    uint8_t scale;
    uint32_t x0, y0, x1, y1;
  };
  Range blocksOf(NodeId n) const;

  static uint32_t bitOf(const BlockId& b) {
    constexpr uint32_t kMask = (1u << kTileLog2) - 1;
    return 1u << ((b.y & kMask) << kTileLog2 | (b.x & kMask));
  }
  const Tile* find(uint8_t scale, uint32_t tile_x, uint32_t tile_y) const;
  Tile* find(uint8_t scale, uint32_t tile_x, uint32_t tile_y) {
    return const_cast<Tile*>(std::as_const(*this).find(scale, tile_x, tile_y));
  }
  Tile& make(uint8_t scale, uint32_t tile_x, uint32_t tile_y);
  // What is known of the blocks of finer scales in a block: whether one of them is visible, or all of it is forgotten.
  bool holdsVisible(const BlockId& block) { return visitFiner(block, Finer::kAnyVisible); }
  void forgetFiner(const BlockId& block) { visitFiner(block, Finer::kForget); }
  // Both in one, for a small module. True where a visible one is looked for and found. Of each scale O(chunks, or rows
  // of tiles), whichever is fewer: a block may hold 10^10 others, of which few can be known.
  enum class Finer : uint8_t { kAnyVisible, kForget };
  bool visitFiner(const BlockId& block, Finer what);
  void forget(Scale& level, Tile& tile, uint32_t bits);

  std::vector<Scale> scales_;
  IndexTable numbers_;                                    // of chunks, by key: they count from scale to scale
  std::vector<ChunkName> order_;                          // ascending
  std::vector<std::array<Tile, kChunkTiles>> chunks_{1};  // by number; that of IndexTable::kNone is of none
  size_t known_ = 0;
  uint32_t root_log2_, max_x_, max_y_;
};

template <class Ask>
bool HiddenBlocks::isHidden(NodeId n, const Ask& ask) {
  const Range r = blocksOf(n);
  for (uint32_t y = r.y0; y <= r.y1; ++y)
    for (uint32_t x = r.x0; x <= r.x1; ++x) {
      const BlockId block{r.scale, x, y};
      BlockState s = state(block);
      if (s == BlockState::kUnknown) {
        const bool is_hidden = !holdsVisible(block) && ask(block);
        set(block, is_hidden);
        s = is_hidden ? BlockState::kHidden : BlockState::kVisible;
      }
      if (s == BlockState::kVisible) return false;
    }
  return true;
}

template <class Visit>
void HiddenBlocks::forEachTile(const Visit& visit) const {
  size_t scale = 0;
  for (const ChunkName& chunk : order_) {
    while (scale + 1 < scales_.size() && chunk.key >= scales_[scale + 1].first_chunk) ++scale;
    const Scale& level = scales_[scale];
    for (uint32_t i = 0; i < kChunkTiles; ++i) {
      const Tile& tile = chunks_[chunk.number][i];
      const uint64_t at = (chunk.key - level.first_chunk) * kChunkTiles + i;
      if (tile.known != 0)
        visit(BlockId{static_cast<uint8_t>(scale), static_cast<uint32_t>(at % level.tiles_x) << kTileLog2,
                      static_cast<uint32_t>(at / level.tiles_x) << kTileLog2},
              tile);
    }
  }
}

template <class Keep>
void HiddenBlocks::retainTiles(const Keep& keep) {
  forEachTile([&](const BlockId& lowest, const Tile& tile) {
    if (keep(lowest)) return;
    const auto count = static_cast<uint32_t>(std::popcount(tile.known));
    known_ -= count;
    scales_[lowest.scale].known -= count;
    const_cast<Tile&>(tile) = {};
  });
}

// Where the server finds out what is hidden (server/occlusion); called during one step of an adaptation.
class BlockVisibility {
 public:
  virtual ~BlockVisibility() = default;
  // The view of the keyframe, first.
  virtual void begin(const View& view) = 0;
  // Of a block that was unknown.
  virtual bool isHidden(const BlockId& block) = 0;
  // Of a tile's blocks that are known, some of which were hidden (HiddenBlocks::Tile): those for which that changes.
  virtual uint32_t changes(const BlockId& lowest, uint32_t known, uint32_t hidden) = 0;
};

}  // namespace foreland::proto
