// Which nodes of a page (kPageSlots) of a grid have a child in the section, or all of their parents, or have all of
// them known to both ends: of all 256 at once, on the bits of the two to five pages that hold these, so that no node is
// named and none looked up. What it must equal, node by node, are GridTopology::children() and parents().
//
// A page of centres has one bit for each cell of a tile of 16 x 16: 16 r + c for the centre of the cell in column c and
// row r. A page of sides has two for each cell of half a tile, 8 rows: 32 r + 2 c for the side below the cell, which
// lies along x, and 32 r + 2 c + 1 for the side on its left, along y. The sides to the right and above are the next
// cells'.
//
// On a cube, pages along its edges are not laid beside those across; for these, and where a face is not larger than a
// few pages, nodes are named one by one.
//
// Reads the nodes while it is used. Any thread that may read them. O(1).
#pragma once

#include <cstdint>

#include "proto/refine/frontier.h"
#include "proto/topology/grid.h"

namespace foreland::proto {

class PageNeighbours {
 public:
  // The nodes that are asked about: those in the section, or those of them that both ends know.
  enum class Of : uint8_t { kSection, kKnown };

  PageNeighbours(const GridTopology& grid, const Frontier::Nodes& nodes, Of of = Of::kSection)
      : grid_(grid), nodes_(nodes), of_(of) {}

  // Where a page is among those of its level: the tile's column and row, and which half of it, 0 or 1, for sides. A
  // place may lie outside of the grid.
  struct Place {
    int32_t x, y, half;
  };
  Place placeOf(int level, Slot first) const;
  // The page's first slot; kNoSlot outside of the grid.
  Slot firstOf(int level, const Place& place) const;

  // Nodes of the page, which need not exist, of which a child is in the section.
  SlotBits withChild(int level, const Place& place) const;
  // Those all of whose parents are. `level` is at least 2.
  SlotBits withParents(int level, const Place& place) const;

  // Calls visit(first slot) for the pages that hold children, or parents, of some of the page's nodes, and perhaps for
  // one that holds none.
  template <class Visit>
  void childPages(int level, const Place& place, const SlotBits& some, const Visit& visit) const;
  template <class Visit>
  void parentPages(int level, const Place& place, const SlotBits& some, const Visit& visit) const;

 private:
  static bool isCentreLevel(int level) { return (level & 1) == 0; }
  // Whether neighbours of the page may not be laid beside it.
  bool isAtSeam(int level, const Place& place) const {
    if (!grid_.isCube()) [[likely]]
      return false;
    const auto last = static_cast<int32_t>(((1u << (static_cast<uint32_t>(level) >> 1)) >> 4) - 1);  // tile of a face
    return last < 1 || (place.x & last) == 0 || (place.x & last) == last || place.y == 0 || place.y == last;
  }
  // Calls visit(low, node) for the nodes of a page.
  template <class Visit>
  void forEachNode(Slot first, const Visit& visit) const {
    for (uint32_t low = 0; low < kPageSlots; ++low)
      if (const NodeId n = grid_.node(first + low); !grid_.isBase(n)) visit(static_cast<uint8_t>(low), n);
  }
  bool has(Slot slot) const;
  SlotBits withChildAtSeam(int level, Slot first) const;
  SlotBits withParentsAtSeam(int level, Slot first) const;
  const SlotBits& inSection(int level, const Place& place) const;
  SlotBits centresWithChild(int level, const Place& place) const;
  SlotBits sidesWithChild(int level, const Place& place) const;
  SlotBits centresWithParents(int level, const Place& place) const;
  SlotBits sidesWithParents(int level, const Place& place) const;

  const GridTopology& grid_;
  const Frontier::Nodes& nodes_;
  const Of of_;
};

template <class Visit>
void PageNeighbours::childPages(int level, const Place& p, const SlotBits& some, const Visit& visit) const {
  if (level == grid_.maxLevel()) return;
  if (isAtSeam(level, p)) [[unlikely]] {
    some.forEach([&](uint8_t low) {
      for (const NodeId child : grid_.children(grid_.node(firstOf(level, p) + low), level))
        visit(grid_.slot(child, level + 1) & ~(kPageSlots - 1));
    });
    return;
  }
  const auto visitAt = [&](int32_t x, int32_t y, int32_t half) {
    if (const Slot first = firstOf(level + 1, {x, y, half}); first != kNoSlot) visit(first);
  };
  const auto& w = some.words;
  if (isCentreLevel(level)) {  // the sides around cells
    constexpr uint64_t kLastColumn = 0x8000800080008000u;
    const uint64_t low = w[0] | w[1], high = w[2] | w[3];
    if (low != 0) visitAt(p.x, p.y, 0);
    if (high != 0 || w[1] >> 48 != 0) visitAt(p.x, p.y, 1);
    if ((low & kLastColumn) != 0) visitAt(p.x + 1, p.y, 0);
    if ((high & kLastColumn) != 0) visitAt(p.x + 1, p.y, 1);
    if (w[3] >> 48 != 0) visitAt(p.x, p.y + 1, 0);
    return;
  }
  // Centres of half the scale: those of a side along x in the rows below and above it, of one along y to its left and
  // right.
  const uint64_t any = w[0] | w[1] | w[2] | w[3];
  const auto columns = static_cast<uint32_t>(any | any >> 32), below = static_cast<uint32_t>(w[0]) & 0x55555555u;
  const int32_t x = 2 * p.x, y = 2 * p.y + p.half;
  if ((columns & 0x0002ffffu) != 0) visitAt(x, y, 0);  // one along y at the ninth column has one in this half, too
  if ((columns & 0xffff0000u) != 0) visitAt(x + 1, y, 0);
  if ((columns & 2u) != 0) visitAt(x - 1, y, 0);
  if ((below & 0xffffu) != 0) visitAt(x, y - 1, 0);
  if (below >> 16 != 0) visitAt(x + 1, y - 1, 0);
}

template <class Visit>
void PageNeighbours::parentPages(int level, const Place& p, const SlotBits& some, const Visit& visit) const {
  if (level == 1) return;
  if (isAtSeam(level, p)) [[unlikely]] {
    some.forEach([&](uint8_t low) {
      for (const NodeId parent : grid_.parents(grid_.node(firstOf(level, p) + low), level))
        visit(grid_.slot(parent, level - 1) & ~(kPageSlots - 1));
    });
    return;
  }
  const auto visitAt = [&](int32_t x, int32_t y, int32_t half) {
    if (const Slot first = firstOf(level - 1, {x, y, half}); first != kNoSlot) visit(first);
  };
  const uint64_t any = some.words[0] | some.words[1] | some.words[2] | some.words[3];
  if (isCentreLevel(level)) {  // sides of the cell of twice the size around it
    const int32_t x = p.x >> 1, y = p.y >> 1, half = p.y & 1;
    visitAt(x, y, half);
    if ((p.x & 1) != 0 && (any & 0x8000800080008000u) != 0) visitAt(x + 1, y, half);
    if (some.words[3] >> 48 != 0) half == 0 ? visitAt(x, y, 1) : visitAt(x, y + 1, 0);
    return;
  }
  visitAt(p.x, p.y, 0);
  if (((any | any >> 32) & 2u) != 0) visitAt(p.x - 1, p.y, 0);
  if (p.half == 0 && (some.words[0] & 0x55555555u) != 0) visitAt(p.x, p.y - 1, 0);
}

}  // namespace foreland::proto
