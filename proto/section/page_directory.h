// Which pages of a terrain (kPageSlots) are stored, and where. On the coarse levels all pages are; on the finest, as
// many as the grid's shape says, a page is there or not, and if it is, so are the pages that hold its nodes' parents.
// So a terrain may be fine where somebody has surveyed it, and costs what was surveyed and not what it spans.
//
// Pages that are there have places 0, 1, ...: those of the coarse levels in the order of their slots, so that a terrain
// all of whose pages are there has every record at the place of its slot; then level by level in blocks of 32 x 32
// pages, row by row in a block, as are the blocks of a level. A block is a bitmap and the place of its first page; the
// place of another is found by counting bits.
//
// A view of blocks that must outlive it, with a table to find them. Immutable; any thread. Memory: 44 to 80 bytes a
// block, beside the blocks. A look-up is a comparison where all pages are there, else a division, one probe, and the
// bits of one word.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "base/result.h"
#include "proto/section/index_table.h"
#include "proto/topology/grid.h"

namespace foreland::proto {

// As it stands in a scene file.
struct PageBlock {
  static constexpr uint32_t kSideLog2 = 5, kSide = 1u << kSideLog2;  // pages

  uint64_t key = 0;    // keyOf()
  uint64_t first = 0;  // place of its first page
  static constexpr uint32_t kWords = kSide * kSide / 64;
  std::array<uint64_t, kWords> bits{};  // of the page in column c and row r: bit 32 r + c

  // From the lowest bit: column (26), row (26), face (3), level (9). The face is that of a lattice of several squares
  // that are glued, and 0 in all that there are so far.
  static uint64_t keyOf(int level, uint32_t column, uint32_t row) {
    return static_cast<uint64_t>(level) << 55 | uint64_t{row} << 26 | column;
  }
  int level() const { return static_cast<int>(key >> 55); }
  uint32_t face() const { return static_cast<uint32_t>(key >> 52 & 7); }
  uint32_t column() const { return static_cast<uint32_t>(key & ((1u << 26) - 1)); }
  uint32_t row() const { return static_cast<uint32_t>(key >> 26 & ((1u << 26) - 1)); }
  uint64_t count() const;
};
static_assert(sizeof(PageBlock) == 144);

class PageDirectory {
 public:
  static constexpr uint64_t kNowhere = ~uint64_t{0};

  // Of a grid all of whose pages are there.
  explicit PageDirectory(const GridTopology& grid) : grid_(grid), whole_(grid.slotCount()) {}
  // Refuses blocks that are out of order, without pages, of a level that is whole, with pages outside of the grid, or
  // whose places do not follow each other. `blocks` must outlive it. O(blocks).
  static Result<PageDirectory> create(const GridTopology& grid, std::span<const PageBlock> blocks);

  // The pages of all slots below it are there.
  Slot wholeSlots() const { return whole_; }
  // How many pages are there.
  uint64_t pageCount() const { return page_count_; }
  // The place of a slot's record: that of its page times kPageSlots, and the slot's index in the page. kNowhere if the
  // page is not there.
  uint64_t placeOf(Slot slot) const { return slot < whole_ ? slot : placeInBlocks(slot); }
  bool hasPage(Slot slot) const { return placeOf(slot) != kNowhere; }

  // Calls visit(first slot of a page, its place) for the pages of a block, by place.
  template <class Visit>
  void forEachPage(const PageBlock& block, const Visit& visit) const;
  // The same for all pages that are there.
  template <class Visit>
  void forEachPage(const Visit& visit) const {
    for (Slot first = 0; first < whole_; first += kPageSlots) visit(first, first / kPageSlots);
    for (const PageBlock& block : blocks_) forEachPage(block, visit);
  }
  std::span<const PageBlock> blocks() const { return blocks_; }

 private:
  uint64_t placeInBlocks(Slot slot) const;

  GridTopology grid_;
  Slot whole_;
  uint64_t page_count_ = whole_ / kPageSlots;
  std::span<const PageBlock> blocks_;
  IndexTable numbers_;                                           // 1 + index of a block, by its key
  std::vector<std::array<uint16_t, PageBlock::kWords>> before_;  // of a block's words: pages in those before
};

// The blocks of the pages with some slots, and of all pages that these need: pages of parents. Pages of levels that are
// whole are left out.
std::vector<PageBlock> blocksOf(const GridTopology& grid, std::span<const Slot> slots);

template <class Visit>
void PageDirectory::forEachPage(const PageBlock& block, const Visit& visit) const {
  uint64_t place = block.first;
  for (uint32_t w = 0; w < block.bits.size(); ++w)
    for (uint64_t left = block.bits[w]; left != 0; left &= left - 1) {
      const uint32_t at = w << 6 | static_cast<uint32_t>(std::countr_zero(left));
      visit(grid_.pageAt({block.level(), block.column() << PageBlock::kSideLog2 | at % PageBlock::kSide,
                          block.row() << PageBlock::kSideLog2 | at / PageBlock::kSide}),
            place++);
    }
}

}  // namespace foreland::proto
