// A hash table from slots to positions in an array: open addressing, built in one go, looked up often. One owner.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/node.h"
#include "proto/section.h"

namespace foreland::client {

class SlotTable {
 public:
  static constexpr uint32_t kAbsent = 0xffffffffu;

  // `slots` are unique. Reuses memory.
  void build(std::span<const proto::Slot> slots) {
    const size_t size = std::bit_ceil(slots.size() * 2 + 2);
    cells_.assign(size, {proto::kNoSlot, kAbsent});
    mask_ = static_cast<uint32_t>(size - 1);
    for (uint32_t i = 0; i < slots.size(); ++i) {
      uint32_t at = hash(slots[i]) & mask_;
      while (cells_[at].slot != proto::kNoSlot) at = (at + 1) & mask_;
      cells_[at] = {slots[i], i};
    }
  }

  uint32_t find(proto::Slot slot) const {
    if (cells_.empty()) return kAbsent;
    uint32_t at = hash(slot) & mask_;
    while (cells_[at].slot != slot) {
      if (cells_[at].slot == proto::kNoSlot) return kAbsent;
      at = (at + 1) & mask_;
    }
    return cells_[at].value;
  }

 private:
  struct Cell {
    proto::Slot slot;
    uint32_t value;
  };
  static uint32_t hash(proto::Slot slot) {
    const uint32_t h = slot * 0x9e3779b1u;
    return h ^ (h >> 15);
  }

  std::vector<Cell> cells_;
  uint32_t mask_ = 0;
};

}  // namespace foreland::client
