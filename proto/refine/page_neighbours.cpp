#include "proto/refine/page_neighbours.h"

#include <algorithm>

namespace foreland::proto {

namespace {

// The even bits, in the lower half.
uint64_t gatherEven(uint64_t bits) {
  bits &= 0x5555555555555555u;
  bits = (bits | bits >> 1) & 0x3333333333333333u;
  bits = (bits | bits >> 2) & 0x0f0f0f0f0f0f0f0fu;
  bits = (bits | bits >> 4) & 0x00ff00ff00ff00ffu;
  bits = (bits | bits >> 8) & 0x0000ffff0000ffffu;
  return (bits | bits >> 16) & 0x00000000ffffffffu;
}
// The lower half, at the even bits.
uint64_t spreadToEven(uint64_t bits) {
  bits &= 0x00000000ffffffffu;
  bits = (bits | bits << 16) & 0x0000ffff0000ffffu;
  bits = (bits | bits << 8) & 0x00ff00ff00ff00ffu;
  bits = (bits | bits << 4) & 0x0f0f0f0f0f0f0f0fu;
  bits = (bits | bits << 2) & 0x3333333333333333u;
  return (bits | bits << 1) & 0x5555555555555555u;
}

// A row of a page of centres, 16 bits, and of sides, 32.
uint32_t centreRow(const SlotBits& bits, int row) {
  return static_cast<uint32_t>(bits.words[static_cast<size_t>(row / 4)] >> 16 * (row & 3)) & 0xffffu;
}
uint32_t sideRow(const SlotBits& bits, int row) {
  return static_cast<uint32_t>(bits.words[static_cast<size_t>(row / 2)] >> 32 * (row & 1));
}

}  // namespace

PageNeighbours::Place PageNeighbours::placeOf(int level, Slot first) const {
  const uint32_t sides = level & 1, across = grid_.tilesAlongX(level);
  const uint64_t page = (first - grid_.levelOffset(level)) / kPageSlots, tile = page >> sides;
  return {static_cast<int32_t>(tile % across), static_cast<int32_t>(tile / across), static_cast<int32_t>(page & sides)};
}

Slot PageNeighbours::firstOf(int level, const Place& place) const {
  const uint32_t sides = level & 1, across = grid_.tilesAlongX(level);
  if (place.x < 0 || place.y < 0 || static_cast<uint32_t>(place.x) >= across) return kNoSlot;
  const uint64_t tile = uint64_t{static_cast<uint32_t>(place.y)} * across + static_cast<uint32_t>(place.x);
  const Slot first = grid_.levelOffset(level) + ((tile << sides) + static_cast<uint32_t>(place.half)) * kPageSlots;
  return first < grid_.levelOffset(level + 1) ? first : kNoSlot;
}

const SlotBits& PageNeighbours::inSection(int level, const Place& place) const {
  const Slot first = firstOf(level, place);
  const FrontierPage& page = nodes_.page(first == kNoSlot ? Frontier::Nodes::kNone : nodes_.find(first));
  return of_ == Of::kSection ? page.in_section : page.knowledge.known;
}

SlotBits PageNeighbours::withChild(int level, const Place& place) const {
  if (level == grid_.maxLevel()) return {};
  if (isAtSeam(level, place)) [[unlikely]]
    return withChildAtSeam(level, firstOf(level, place));
  return isCentreLevel(level) ? centresWithChild(level, place) : sidesWithChild(level, place);
}

SlotBits PageNeighbours::withParents(int level, const Place& place) const {
  if (isAtSeam(level, place)) [[unlikely]]
    return withParentsAtSeam(level, firstOf(level, place));
  return isCentreLevel(level) ? centresWithParents(level, place) : sidesWithParents(level, place);
}

bool PageNeighbours::has(Slot slot) const {
  const FrontierPage& page = nodes_.page(nodes_.find(slot));
  return (of_ == Of::kSection ? page.in_section : page.knowledge.known).has(lowOf(slot));
}

SlotBits PageNeighbours::withChildAtSeam(int level, Slot first) const {
  SlotBits out;
  forEachNode(first, [&](uint8_t low, NodeId n) {
    bool any = false;
    for (const NodeId child : grid_.children(n, level)) any = any || has(grid_.slot(child, level + 1));
    out.add(low, any);
  });
  return out;
}

SlotBits PageNeighbours::withParentsAtSeam(int level, Slot first) const {
  SlotBits out;
  forEachNode(first, [&](uint8_t low, NodeId n) {
    bool all = true;
    for (const NodeId parent : grid_.parents(n, level)) all = all && has(grid_.slot(parent, level - 1));
    out.add(low, all);
  });
  return out;
}

// Children are the four sides of the cell, two of which are the next cells'.
SlotBits PageNeighbours::centresWithChild(int level, const Place& p) const {
  const auto sidesAt = [&](int32_t x, int32_t y, int32_t half) -> const SlotBits& {
    return inSection(level + 1, {x, y, half});
  };
  const SlotBits *own[2] = {&sidesAt(p.x, p.y, 0), &sidesAt(p.x, p.y, 1)},
                 *right[2] = {&sidesAt(p.x + 1, p.y, 0), &sidesAt(p.x + 1, p.y, 1)};
  const uint64_t above = sideRow(sidesAt(p.x, p.y + 1, 0), 0);
  SlotBits out;
  for (size_t i = 0; i < 8; ++i) {  // two rows
    const uint64_t rows = own[i / 4]->words[i & 3];
    const uint64_t row_after = i == 7 ? above : own[(i + 1) / 4]->words[(i + 1) & 3];
    const uint64_t next_rows = rows >> 32 | row_after << 32;
    const uint64_t next_columns = (rows >> 3 & 0x1fffffff1fffffffu) | (right[i / 4]->words[i & 3] & 0x0000000200000002u)
                                                                          << 29;
    out.words[i / 2] |= gatherEven(rows | next_rows | rows >> 1 | next_columns) << 32 * (i & 1);
  }
  return out;
}

// Children are centres of half the scale, of a side along x two in the row below it and two in that above, of one along
// y two in the column on its left and two on its right.
SlotBits PageNeighbours::sidesWithChild(int level, const Place& p) const {
  const auto centresAt = [&](int32_t x, int32_t y) -> const SlotBits& { return inSection(level + 1, {x, y, 0}); };
  const int32_t x = 2 * p.x, y = 2 * p.y + p.half;
  const SlotBits &west = centresAt(x, y), &east = centresAt(x + 1, y), &left = centresAt(x - 1, y);
  const auto row = [&](int r) { return centreRow(west, r) | centreRow(east, r) << 16; };
  uint32_t below = centreRow(centresAt(x, y - 1), 15) | centreRow(centresAt(x + 1, y - 1), 15) << 16;
  SlotBits out;
  for (int r = 0; r < 8; ++r) {
    const uint32_t lower = row(2 * r), upper = row(2 * r + 1), around_x = below | lower, around_y = lower | upper;
    const uint32_t left_y = (centreRow(left, 2 * r) | centreRow(left, 2 * r + 1)) >> 15;
    const uint32_t along_x = (around_x | around_x >> 1) & 0x55555555u,
                   along_y = (around_y | around_y << 1 | left_y) & 0x55555555u;
    out.words[static_cast<size_t>(r / 2)] |= uint64_t{along_x | along_y << 1} << 32 * (r & 1);
    below = upper;
  }
  return out;
}

// Parents are the centres on both sides of it, of which one may lie beyond the border.
SlotBits PageNeighbours::sidesWithParents(int level, const Place& p) const {
  const auto centresAt = [&](int32_t x, int32_t y) -> const SlotBits& { return inSection(level - 1, {x, y, 0}); };
  const uint32_t size_log2 = grid_.shape().root_log2 - (static_cast<uint32_t>(level) >> 1);  // of a cell
  const auto cells_x = static_cast<int32_t>(grid_.maxX() >> size_log2) - 16 * p.x,
             cells_y = static_cast<int32_t>(grid_.maxY() >> size_log2) - 16 * p.y;  // from this tile on
  const uint32_t is_beyond_x = cells_x >= 16 ? 0 : 0xffffu & ~0u << std::max(cells_x, 0),
                 is_before_x = p.x == 0 ? 1 : 0;
  const SlotBits &own = centresAt(p.x, p.y), &west = centresAt(p.x - 1, p.y);
  uint32_t below = p.half == 0 ? centreRow(centresAt(p.x, p.y - 1), 15) : centreRow(own, 7);
  SlotBits out;
  for (int r = 0; r < 8; ++r) {
    const int row = 8 * p.half + r;
    const uint32_t here = centreRow(own, row), left = (here << 1 | centreRow(west, row) >> 15) & 0xffffu;
    const uint32_t is_beyond_y = row >= cells_y ? 0xffffu : 0, is_before_y = row == 0 && p.y == 0 ? 0xffffu : 0;
    const uint32_t along_x = (here | is_beyond_y) & (below | is_before_y) & (here | below),
                   along_y = (here | is_beyond_x) & (left | is_before_x) & (here | left);
    // Both spread at once.
    const uint64_t pairs = spreadToEven(along_x | along_y << 16);
    out.words[static_cast<size_t>(r / 2)] |= ((pairs & 0xffffffffu) | pairs >> 32 << 1) << 32 * (r & 1);
    below = here;
  }
  return out;
}

// Parents are two sides of the cell of twice the size: below or above, and left or right.
SlotBits PageNeighbours::centresWithParents(int level, const Place& p) const {
  const auto sidesAt = [&](int32_t x, int32_t y, int32_t half) -> const SlotBits& {
    return inSection(level - 1, {x, y, half});
  };
  const int32_t x = p.x >> 1, y = p.y >> 1, half = p.y & 1;
  const bool is_east = (p.x & 1) != 0;
  const SlotBits &own = sidesAt(x, y, half), &right = is_east ? sidesAt(x + 1, y, half) : own,
                 &above = half == 0 ? sidesAt(x, y, 1) : sidesAt(x, y + 1, 0);
  const int shift = is_east ? 16 : 0;
  SlotBits out;
  uint32_t row = sideRow(own, 0);
  for (int r = 0; r < 8; ++r) {
    const uint32_t next = r == 7 ? sideRow(above, 0) : sideRow(own, r + 1);
    const uint32_t here = row >> shift & 0xffffu, last = is_east ? sideRow(right, r) >> 1 & 1 : row >> 17 & 1;
    const uint32_t lower = here & 0x5555u, upper = next >> shift & 0x5555u, left = here >> 1 & 0x5555u,
                   right_y = left >> 2 | last << 14;
    const uint32_t lower_row = (lower & left) | (lower & right_y) << 1, upper_row = (upper & left) | (upper & right_y)
                                                                                                         << 1;
    out.words[static_cast<size_t>(r / 2)] |= uint64_t{lower_row | upper_row << 16} << 32 * (r & 1);
    row = next;
  }
  return out;
}

}  // namespace foreland::proto
