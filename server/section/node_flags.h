// Two bits for each of the slots that a session has touched, in pages of 256 slots (a tile of the scene's slot order, so neighbours
// share a page): is the node active, is it listed on the frontier. A page lives as long as it has a bit set.
// One owner. A look-up is one probe of a small hash table; no allocation once it has grown to the session's size.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "proto/node.h"

namespace foreland::server {

class NodeFlags {
 public:
  NodeFlags() : cells_(64) {}

  bool active(proto::Slot slot) const { return get(slot, 0); }
  bool listed(proto::Slot slot) const { return get(slot, 1); }
  void setActive(proto::Slot slot, bool value) { set(slot, 0, value); }
  void setListed(proto::Slot slot, bool value) { set(slot, 1, value); }

  // Calls `visit(slot)` for each active node, in no particular order.
  template <class F>
  void forEachActive(F&& visit) const {
    for (const Page& page : pages_)
      for (uint32_t w = 0; w < 4; ++w)
        for (uint64_t bits = page.words[0][w]; bits != 0; bits &= bits - 1)
          visit(page.key << 8 | w << 6 | static_cast<uint32_t>(std::countr_zero(bits)));
  }

  size_t bytes() const { return cells_.capacity() * sizeof(Cell) + pages_.capacity() * sizeof(Page); }

 private:
  static constexpr uint32_t kEmpty = 0xffffffffu;
  struct Page {
    std::array<std::array<uint64_t, 4>, 2> words{};  // active, listed
    uint32_t key = 0;                                // slot >> 8
    uint32_t bits_set = 0;
  };
  struct Cell {
    uint32_t key = 0;
    uint32_t page = kEmpty;
  };

  uint32_t home(uint32_t key) const { return (key * 0x9e3779b1u) >> shift_; }
  uint32_t mask() const { return static_cast<uint32_t>(cells_.size() - 1); }
  // Cell of the page with this key, or the empty cell where it would be.
  uint32_t probe(uint32_t key) const {
    uint32_t at = home(key);
    while (cells_[at].key != key && cells_[at].page != kEmpty) at = (at + 1) & mask();
    return at;
  }
  bool get(proto::Slot slot, uint32_t plane) const {
    const uint32_t page = cells_[probe(slot >> 8)].page;
    return page != kEmpty && (pages_[page].words[plane][slot >> 6 & 3] >> (slot & 63) & 1);
  }
  void set(proto::Slot slot, uint32_t plane, bool value);
  void grow();
  void erase(uint32_t cell);

  std::vector<Cell> cells_;  // power of two, open addressing; an empty cell's key says nothing
  uint32_t shift_ = 26;
  std::vector<Page> pages_;  // dense
};

}  // namespace foreland::server
