// Three bits for each of the slots that a session has touched, in pages of 256 slots (a tile of the scene's slot order,
// so neighbours share a page): is the node active, has it an entry on the frontier's list, has it left the frontier
// since. A page lives as long as it has a bit set. One owner. A look-up is one probe of a small hash table; no
// allocation once it has grown to the session's size.
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

  enum Flag : uint32_t { kActive, kListed, kLeft };

  bool get(Flag flag, proto::Slot slot) const {
    const uint32_t page = cells_[probe(slot >> 8)].page;
    return page != kEmpty && (pages_[page][slot >> 6 & 3][flag] >> (slot & 63) & 1);
  }
  // All flags of a slot at once: bit `flag` of the result.
  uint32_t all(proto::Slot slot) const {
    const uint32_t page = cells_[probe(slot >> 8)].page;
    if (page == kEmpty) return 0;
    const std::array<uint64_t, 3>& word = pages_[page][slot >> 6 & 3];
    const uint32_t at = slot & 63;
    return static_cast<uint32_t>((word[0] >> at & 1) | (word[1] >> at & 1) << 1 | (word[2] >> at & 1) << 2);
  }
  void set(Flag flag, proto::Slot slot, bool value);
  // Sets kLeft if kListed is set.
  void leaveIfListed(proto::Slot slot) {
    const uint32_t page = cells_[probe(slot >> 8)].page;
    if (page == kEmpty) return;
    std::array<uint64_t, 3>& word = pages_[page][slot >> 6 & 3];
    const uint64_t bit = word[kListed] & ~word[kLeft] & uint64_t{1} << (slot & 63);
    word[kLeft] |= bit;
    infos_[page].bits_set += bit != 0;
  }

  // Calls `visit(slot)` for each active node, in no particular order.
  template <class F>
  void forEachActive(F&& visit) const {
    for (size_t i = 0; i < pages_.size(); ++i)
      for (uint32_t w = 0; w < 4; ++w)
        for (uint64_t bits = pages_[i][w][kActive]; bits != 0; bits &= bits - 1)
          visit(infos_[i].key << 8 | w << 6 | static_cast<uint32_t>(std::countr_zero(bits)));
  }

  size_t bytes() const {
    return cells_.capacity() * sizeof(Cell) + pages_.capacity() * (sizeof(Page) + sizeof(PageInfo));
  }

 private:
  static constexpr uint32_t kEmpty = 0xffffffffu;
  using Page = std::array<std::array<uint64_t, 3>, 4>;  // by 64 slots, then by flag
  struct PageInfo {
    uint32_t key = 0;  // slot >> 8
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
  void grow();
  void erase(uint32_t cell);

  std::vector<Cell> cells_;  // power of two, open addressing; an empty cell's key says nothing
  uint32_t shift_ = 26;
  std::vector<Page> pages_;  // dense
  std::vector<PageInfo> infos_;
};

}  // namespace foreland::server
