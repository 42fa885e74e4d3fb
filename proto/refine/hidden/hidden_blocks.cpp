#include "proto/refine/hidden/hidden_blocks.h"

#include <algorithm>

#include "base/check.h"

namespace foreland::proto {

namespace {

uint32_t divideUp(uint32_t a, uint32_t log2) { return (a + (1u << log2) - 1) >> log2; }

// Of blocks, from the lowest to the highest, both included.
struct Square {
  uint32_t x0, y0, x1, y1;

  // What of a tile lies in it, as bits of its blocks.
  uint32_t bitsOf(uint32_t tile_x, uint32_t tile_y) const {
    constexpr uint32_t kLog2 = HiddenBlocks::kTileLog2, kMask = (1u << kLog2) - 1;
    uint32_t bits = 0;
    for (uint32_t i = 0; i < HiddenBlocks::kTileBlocks; ++i) {
      const uint32_t x = (tile_x << kLog2) + (i & kMask), y = (tile_y << kLog2) + (i >> kLog2);
      if (x >= x0 && x <= x1 && y >= y0 && y <= y1) bits |= 1u << i;
    }
    return bits;
  }
};

}  // namespace

HiddenBlocks::HiddenBlocks(const GridTopology& grid)
    : root_log2_(grid.shape().root_log2), max_x_(grid.maxX()), max_y_(grid.maxY()) {
  uint64_t chunks = 0;
  for (uint32_t scale = 0; scale < root_log2_; ++scale) {
    const uint32_t side_log2 = scale + BlockId::kSideLog2 + kTileLog2;
    const Scale s{divideUp(max_x_, side_log2), divideUp(max_y_, side_log2), chunks};
    chunks += (uint64_t{s.tiles_x} * s.tiles_y + kChunkTiles - 1) / kChunkTiles;
    scales_.push_back(s);
  }
}

const HiddenBlocks::Tile* HiddenBlocks::find(uint8_t scale, uint32_t tile_x, uint32_t tile_y) const {
  const Scale& level = scales_[scale];
  if (level.known == 0) return nullptr;
  const uint64_t at = uint64_t{tile_y} * level.tiles_x + tile_x;
  const uint32_t chunk = numbers_.find(level.first_chunk + at / kChunkTiles);
  return chunk == IndexTable::kNone ? nullptr : &chunks_[chunk][at % kChunkTiles];
}

HiddenBlocks::Tile& HiddenBlocks::make(uint8_t scale, uint32_t tile_x, uint32_t tile_y) {
  const Scale& level = scales_[scale];
  const uint64_t at = uint64_t{tile_y} * level.tiles_x + tile_x, key = level.first_chunk + at / kChunkTiles;
  uint32_t chunk = numbers_.find(key);
  if (chunk == IndexTable::kNone) {
    chunk = static_cast<uint32_t>(chunks_.size());
    chunks_.emplace_back();
    numbers_.insert(key, chunk);
    order_.insert(std::ranges::lower_bound(order_, key, {}, &ChunkName::key), {key, chunk});
  }
  return chunks_[chunk][at % kChunkTiles];
}

BlockState HiddenBlocks::state(const BlockId& block) const {
  for (BlockId b = block; b.scale < scales_.size(); b = b.parent()) {
    const Tile* tile = find(b.scale, b.x >> kTileLog2, b.y >> kTileLog2);
    if (!tile || !(tile->known & bitOf(b))) continue;
    if (tile->hidden & bitOf(b)) return BlockState::kHidden;
    return b == block ? BlockState::kVisible : BlockState::kUnknown;
  }
  return BlockState::kUnknown;
}

BlockState HiddenBlocks::stateInside(const BlockId& block) const {
  const Scale& level = scales_[block.scale];
  const bool is_inside = block.x >> kTileLog2 < level.tiles_x && block.y >> kTileLog2 < level.tiles_y;
  return is_inside ? state(block) : BlockState::kUnknown;
}

void HiddenBlocks::set(const BlockId& block, bool is_hidden) {
  Tile& tile = make(block.scale, block.x >> kTileLog2, block.y >> kTileLog2);
  const uint32_t bit = bitOf(block);
  const uint32_t is_new = (tile.known & bit) ? 0 : 1;
  known_ += is_new;
  scales_[block.scale].known += is_new;
  tile.known |= static_cast<uint16_t>(bit);
  tile.hidden = static_cast<uint16_t>(is_hidden ? tile.hidden | bit : tile.hidden & ~bit);
  if (is_hidden) forgetFiner(block);
}

bool HiddenBlocks::visitFiner(const BlockId& block, Finer what) {
  for (uint32_t scale = block.scale; scale-- > 0;) {
    Scale& level = scales_[scale];
    if (level.known == 0) continue;
    const uint32_t shift = block.scale - scale, most = (1u << shift) - 1;
    const Square blocks{block.x << shift, block.y << shift, (block.x << shift) + most, (block.y << shift) + most};
    const uint32_t first_x = blocks.x0 >> kTileLog2, last_x = std::min(blocks.x1 >> kTileLog2, level.tiles_x - 1),
                   first_y = blocks.y0 >> kTileLog2, last_y = std::min(blocks.y1 >> kTileLog2, level.tiles_y - 1);
    const uint64_t last = uint64_t{last_y} * level.tiles_x + last_x;
    auto chunk = order_.begin();
    for (uint64_t at = uint64_t{first_y} * level.tiles_x + first_x; at <= last;) {  // the next tile, row by row
      chunk = std::ranges::lower_bound(chunk, order_.end(), level.first_chunk + at / kChunkTiles, {}, &ChunkName::key);
      if (chunk == order_.end()) break;
      const uint64_t first = (chunk->key - level.first_chunk) * kChunkTiles;
      for (at = std::max(at, first); at < std::min(first + kChunkTiles, last + 1); ++at) {
        Tile& tile = chunks_[chunk->number][at % kChunkTiles];
        if (tile.known == 0) continue;
        const uint32_t bits = tile.known & blocks.bitsOf(static_cast<uint32_t>(at % level.tiles_x),
                                                         static_cast<uint32_t>(at / level.tiles_x));
        if (what == Finer::kForget)
          forget(level, tile, bits);
        else if ((bits & ~tile.hidden) != 0)
          return true;
      }
      const auto x = static_cast<uint32_t>(at % level.tiles_x);
      if (x < first_x) at += first_x - x;
      if (x > last_x) at += level.tiles_x - x + first_x;
    }
  }
  return false;
}

void HiddenBlocks::forget(Scale& level, Tile& tile, uint32_t bits) {
  const auto count = static_cast<uint32_t>(std::popcount(bits));
  known_ -= count;
  level.known -= count;
  tile.known &= static_cast<uint16_t>(~bits);
  tile.hidden &= static_cast<uint16_t>(~bits);
}

HiddenBlocks::Range HiddenBlocks::blocksOf(NodeId n) const {
  const uint32_t t = static_cast<uint32_t>(std::countr_zero((n.x() | n.y()) | (1u << root_log2_))), s = 1u << t;
  const bool is_centre = (n.x() >> t & 1) && (n.y() >> t & 1);
  const uint32_t reach = is_centre ? 3 * s : 2 * s, side_log2 = t + BlockId::kSideLog2;
  const auto low = [&](uint32_t v) { return (v > reach ? v - reach : 0) >> side_log2; };
  const auto high = [&](uint32_t v, uint32_t most) { return (std::min(v + reach, most) - 1) >> side_log2; };
  return {static_cast<uint8_t>(t), low(n.x()), low(n.y()), high(n.x(), max_x_), high(n.y(), max_y_)};
}

bool HiddenBlocks::isKnownHidden(NodeId n) const {
  const Range r = blocksOf(n);
  for (uint32_t y = r.y0; y <= r.y1; ++y)
    for (uint32_t x = r.x0; x <= r.x1; ++x)
      if (state({r.scale, x, y}) != BlockState::kHidden) return false;
  return true;
}

void HiddenBlocks::clear() {
  numbers_.reset(0);
  order_.clear();
  chunks_.resize(1);
  for (Scale& scale : scales_) scale.known = 0;
  known_ = 0;
}

size_t HiddenBlocks::bytes() const {
  return numbers_.bytes() + order_.capacity() * sizeof(ChunkName) + chunks_.capacity() * sizeof(chunks_[0]) +
         scales_.capacity() * sizeof(Scale);
}

}  // namespace foreland::proto
