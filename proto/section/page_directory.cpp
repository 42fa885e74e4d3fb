#include "proto/section/page_directory.h"

#include <map>
#include <set>
#include <string>

namespace foreland::proto {

namespace {

constexpr uint32_t kSideMask = PageBlock::kSide - 1;

uint64_t keyOf(const PagePlace& page) {
  return PageBlock::keyOf(page.level, page.column >> PageBlock::kSideLog2, page.row >> PageBlock::kSideLog2);
}
uint32_t bitOf(const PagePlace& page) {
  return (page.row & kSideMask) << PageBlock::kSideLog2 | (page.column & kSideMask);
}

Slot pageBegin(Slot slot) { return slot - slot % kPageSlots; }
uint32_t blocksAlong(uint32_t pages) { return (pages + kSideMask) >> PageBlock::kSideLog2; }

// The bits of pages inside of the grid, of a block that is.
bool isInside(const GridTopology& grid, const PageBlock& block) {
  const uint32_t columns = grid.pageColumns(block.level()), rows = grid.pageRows(block.level());
  if (block.column() >= blocksAlong(columns) || block.row() >= blocksAlong(rows)) return false;
  const uint32_t left = columns - block.column() * PageBlock::kSide, up = rows - block.row() * PageBlock::kSide;
  for (uint32_t row = 0; row < PageBlock::kSide; ++row) {
    const auto bits = static_cast<uint32_t>(block.bits[row / 2] >> 32 * (row % 2));
    if (row >= up ? bits != 0 : left < PageBlock::kSide && bits >> left != 0) return false;
  }
  return true;
}

// For each of a block's words, how many of its pages are in those before.
std::array<uint16_t, PageBlock::kWords> pagesBefore(const PageBlock& block) {
  std::array<uint16_t, PageBlock::kWords> before{};
  for (size_t w = 1; w < before.size(); ++w)
    before[w] = static_cast<uint16_t>(before[w - 1] + std::popcount(block.bits[w - 1]));
  return before;
}

}  // namespace

uint64_t PageBlock::count() const {
  uint64_t sum = 0;
  for (const uint64_t word : bits) sum += static_cast<uint64_t>(std::popcount(word));
  return sum;
}

Result<PageDirectory> PageDirectory::create(const GridTopology& grid, std::span<const PageBlock> blocks) {
  PageDirectory directory(grid);
  directory.whole_ = grid.levelOffset(grid.wholeLevels() + 1);
  directory.page_count_ = directory.whole_ / kPageSlots;
  directory.blocks_ = blocks;
  directory.numbers_.reset(blocks.size());
  directory.before_.reserve(blocks.size());
  for (size_t i = 0; i < blocks.size(); ++i) {
    const PageBlock& block = blocks[i];
    const auto refuse = [&](const char* what) {
      return Error{ErrorCode::kMalformed, "directory of pages: block " + std::to_string(i) + " " + what};
    };
    if (i > 0 && block.key <= blocks[i - 1].key) return refuse("is out of order");
    if (block.level() <= grid.wholeLevels() || block.level() > grid.maxLevel()) return refuse("is of a wrong level");
    if (block.face() != 0) return refuse("is of a face that the grid does not have");
    if (block.count() == 0 || !isInside(grid, block)) return refuse("has no page, or one outside of the grid");
    if (block.first != directory.page_count_) return refuse("has a wrong place");
    directory.page_count_ += block.count();
    directory.numbers_.insert(block.key, static_cast<uint32_t>(i + 1));
    directory.before_.push_back(pagesBefore(block));
  }
  return directory;
}

uint64_t PageDirectory::placeInBlocks(Slot slot) const {
  const PagePlace page = grid_.pagePlace(slot);
  const uint32_t number = numbers_.find(keyOf(page));
  if (number == IndexTable::kNone) return kNowhere;
  const PageBlock& block = blocks_[number - 1];
  const uint32_t bit = bitOf(page), word = bit / 64;
  if ((block.bits[word] >> bit % 64 & 1) == 0) return kNowhere;
  const auto in_word = static_cast<uint64_t>(std::popcount(block.bits[word] & ((uint64_t{1} << bit % 64) - 1)));
  return (block.first + before_[number - 1][word] + in_word) * kPageSlots + slot % kPageSlots;
}

namespace {

// The first slots of the pages that hold parents of a page's nodes.
void addParentPages(const GridTopology& grid, int level, Slot first, std::set<Slot>& out) {
  const auto nodes = grid.pageNodes(level, first);
  for (uint32_t low = 0; low < kPageSlots; ++low)
    if (const NodeId n = nodes.at(low); grid.contains(n))
      for (const NodeId parent : grid.parents(n, level)) out.insert(pageBegin(grid.slot(parent, level - 1)));
}

}  // namespace

std::vector<PageBlock> blocksOf(const GridTopology& grid, std::span<const Slot> slots) {
  std::set<Slot> pages;  // by their first slots
  for (const Slot slot : slots) pages.insert(pageBegin(slot));
  std::map<uint64_t, PageBlock> blocks;
  for (int level = grid.maxLevel(); level > grid.wholeLevels(); --level)
    for (auto page = pages.lower_bound(grid.levelOffset(level));
         page != pages.end() && *page < grid.levelOffset(level + 1); ++page) {
      const PagePlace at = grid.pagePlace(*page);
      PageBlock& block = blocks[keyOf(at)];
      block.key = keyOf(at);
      block.bits[bitOf(at) / 64] |= uint64_t{1} << bitOf(at) % 64;
      addParentPages(grid, level, *page, pages);
    }
  std::vector<PageBlock> out;
  uint64_t place = grid.levelOffset(grid.wholeLevels() + 1) / kPageSlots;
  for (auto& [key, block] : blocks) {
    block.first = place;
    place += block.count();
    out.push_back(block);
  }
  return out;
}

}  // namespace foreland::proto
