// Hidden blocks of the terrain as coded decisions (refine/hidden_blocks.h): at the start of a delta whether nodes of
// hidden blocks are left out at all, then which of the blocks that both ends know have changed, tile by tile; and, as
// the adapter asks for them, whether blocks that were unknown are hidden. The same code writes and reads: an encoder
// has a BlockVisibility that it asks, a decoder none. One owner of a model; portable to WebAssembly.
#pragma once

#include <array>
#include <bit>
#include <vector>

#include "proto/codec/range_coder.h"
#include "proto/refine/hidden/hidden_blocks.h"

namespace foreland::proto {

struct BlockModel {
  std::array<AdaptiveBit, 2> hides;              // by whether the last delta did
  std::array<AdaptiveBit, 4> tile_changes;       // by whether the last two tiles did
  std::array<AdaptiveBit, 2 * 2> block_changes;  // by whether it is hidden, and another of its tile has changed
  std::array<AdaptiveBit, 3 * 3 * 4> is_hidden;  // by hidden and by visible neighbours, and by scale
};

template <class Coder>
class BlockCoder {
 public:
  BlockCoder(Coder& coder, BlockModel& model) : coder_(coder), model_(model) {}

  // Nothing is hidden if `visibility` is null; a decoder passes null and gets `hides`.
  void codeChanges(const HiddenBlocks& blocks, BlockVisibility* visibility, bool& hides,
                   std::vector<BlockId>& changed) {
    hides = coder_.code(model_.hides[hides ? 1 : 0], visibility != nullptr);
    if (!hides) return;
    size_t before = 0;  // whether there were changes in the last two tiles
    blocks.forEachTile([&](const BlockId& lowest, const HiddenBlocks::Tile& tile) {
      const bool any = codeTile(lowest, tile, visibility, before, changed);
      before = (2 * before + (any ? 1 : 0)) & 3;
    });
  }

  bool codeHidden(const HiddenBlocks& blocks, const BlockId& block, bool is_hidden) {
    uint32_t hidden = 0, visible = 0;
    const auto look = [&](uint32_t x, uint32_t y) {
      const BlockState state = blocks.stateInside({block.scale, x, y});
      hidden += state == BlockState::kHidden ? 1 : 0;
      visible += state == BlockState::kVisible ? 1 : 0;
    };
    if (block.x > 0) look(block.x - 1, block.y);
    if (block.y > 0) look(block.x, block.y - 1);
    look(block.x + 1, block.y);
    look(block.x, block.y + 1);
    const uint32_t scale = std::min<uint32_t>(block.scale, 3);
    return coder_.code(model_.is_hidden[(scale * 3 + std::min(hidden, 2u)) * 3 + std::min(visible, 2u)], is_hidden);
  }

 private:
  bool codeTile(const BlockId& lowest, const HiddenBlocks::Tile& tile, BlockVisibility* visibility, size_t before,
                std::vector<BlockId>& changed) {
    const auto blockAt = [&](uint32_t bit) {
      constexpr uint32_t kMask = (1u << HiddenBlocks::kTileLog2) - 1;
      return BlockId{lowest.scale, lowest.x + (bit & kMask), lowest.y + (bit >> HiddenBlocks::kTileLog2)};
    };
    // An encoder's changes.
    const uint32_t wanted = visibility ? visibility->changes(lowest, tile.known, tile.hidden) & tile.known : 0;
    if (!coder_.code(model_.tile_changes[before], wanted != 0)) return false;
    bool any = false;
    for (uint32_t left = tile.known; left != 0; left &= left - 1) {
      const auto bit = static_cast<uint32_t>(std::countr_zero(left));
      const bool is_implied = !any && (left & (left - 1)) == 0;
      auto& context = model_.block_changes[(tile.hidden >> bit & 1) * 2 + (any ? 1 : 0)];
      if (!is_implied && !coder_.code(context, wanted >> bit & 1)) continue;
      any = true;
      changed.push_back(blockAt(bit));
    }
    return true;
  }

  Coder& coder_;
  BlockModel& model_;
};

}  // namespace foreland::proto
