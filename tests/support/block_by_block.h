// A visibility of blocks that is told block by block which of those that are known are still hidden.
#pragma once

#include <bit>

#include "proto/refine/hidden/hidden_blocks.h"

namespace foreland::test {

class BlockByBlock : public proto::BlockVisibility {
 public:
  virtual bool isStillHidden(const proto::BlockId& block, bool was_hidden) = 0;

  uint32_t changes(const proto::BlockId& lowest, uint32_t known, uint32_t hidden) final {
    constexpr uint32_t kMask = (1u << proto::HiddenBlocks::kTileLog2) - 1;
    uint32_t changed = 0;
    for (uint32_t left = known; left != 0; left &= left - 1) {
      const auto bit = static_cast<uint32_t>(std::countr_zero(left));
      const bool was_hidden = (hidden >> bit & 1) != 0;
      const proto::BlockId block{lowest.scale, lowest.x + (bit & kMask),
                                 lowest.y + (bit >> proto::HiddenBlocks::kTileLog2)};
      if (isStillHidden(block, was_hidden) != was_hidden) changed |= 1u << bit;
    }
    return changed;
  }
};

}  // namespace foreland::test
