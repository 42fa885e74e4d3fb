// From a key to the index of what has that key: the pages of a section (refine/paged_nodes.h), blocks of node
// records (node_tables.h). Open addressing with linear probing at a load of at most a half; 12 bytes a cell. Index 0
// stands for "not there", so callers can keep something empty at index 0 and read it without a branch.
//
// One owner. find() is one probe in most cases; no allocation but to grow. std::unordered_map allocates a node for each
// key and follows two pointers to find it.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "base/check.h"

namespace foreland::proto {

class IndexTable {
 public:
  static constexpr uint32_t kNone = 0;

  // kNone if the key is not there.
  uint32_t find(uint64_t key) const { return cells_[probe(key)].index; }
  size_t size() const { return size_; }
  size_t bytes() const { return cells_.capacity() * sizeof(Cell); }

  // The key must not be there; `index` is not kNone.
  void insert(uint64_t key, uint32_t index) {
    if (2 * (size_ + 1) > cells_.size()) grow();
    Cell& cell = cells_[probe(key)];
    DCHECK_TRUE(cell.index == kNone);
    cell = Cell::of(key, index);
    ++size_;
  }
  // The key must be there. Cells after the freed one move up where their chains passed over it (Knuth, TAOCP 3, 6.4,
  // algorithm R).
  void erase(uint64_t key) {
    uint32_t hole = probe(key);
    DCHECK_TRUE(cells_[hole].index != kNone);
    for (uint32_t at = (hole + 1) & mask(); cells_[at].index != kNone; at = (at + 1) & mask()) {
      const uint32_t from = home(cells_[at].key());
      if (((at - from) & mask()) < ((at - hole) & mask())) continue;
      cells_[hole] = cells_[at];
      hole = at;
    }
    cells_[hole] = {};
    --size_;
  }
  // Forgets all keys; memory becomes what `expected` keys need.
  void reset(size_t expected) {
    const size_t cells = std::bit_ceil(std::max(kFewest, 2 * expected));
    if (cells != cells_.size()) cells_ = std::vector<Cell>(cells);
    std::fill(cells_.begin(), cells_.end(), Cell{});
    shift_ = 64 - std::countr_zero(cells);
    size_ = 0;
  }

 private:
  static constexpr size_t kFewest = 8;
  // The key, which says nothing while the cell is empty, stands in two parts, so that a cell is no larger than what it
  // holds.
  struct Cell {
    std::array<uint32_t, 2> key_parts{};
    uint32_t index = kNone;

    static Cell of(uint64_t key, uint32_t index) { return {std::bit_cast<std::array<uint32_t, 2>>(key), index}; }
    uint64_t key() const { return std::bit_cast<uint64_t>(key_parts); }
  };
  static_assert(sizeof(Cell) == 12);

  // The upper bits of a multiplication by the golden ratio (Knuth, TAOCP 3, 6.4).
  uint32_t home(uint64_t key) const { return static_cast<uint32_t>((key * 0x9e3779b97f4a7c15u) >> shift_); }
  uint32_t mask() const { return static_cast<uint32_t>(cells_.size() - 1); }
  // The cell of the key, or the empty cell where it would be.
  uint32_t probe(uint64_t key) const {
    uint32_t at = home(key);
    while (cells_[at].key() != key && cells_[at].index != kNone) at = (at + 1) & mask();
    return at;
  }
  void grow() {
    const std::vector<Cell> old = std::move(cells_);
    cells_ = std::vector<Cell>(2 * old.size());
    --shift_;
    for (const Cell& cell : old)
      if (cell.index != kNone) cells_[probe(cell.key())] = cell;
  }

  std::vector<Cell> cells_ = std::vector<Cell>(kFewest);  // a power of two
  int shift_ = 61;                                        // 64 less the number of bits of a cell's number
  size_t size_ = 0;
};

}  // namespace foreland::proto
