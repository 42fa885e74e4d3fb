// Where a frontier's entries live: in one pool, a block of it for each page that has entries. Entries and their slacks,
// or their heights on a frontier that is swept (sweep.h), are two columns, so that a step is one pass of vector
// instructions over each. Blocks come in few sizes, all multiples of a vector, so a block that is given back fits
// others; behind a block's last entry the slacks are endless. One owner; grows by an eighth at a time, for a session's
// memory is counted.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <vector>

#include "proto/section/bounds.h"

namespace foreland::proto {

// How motion is taken off a slack: the kind of motion that counts (Sensitivity in motion_margin.h), and the largest
// distance from the eye that the node can have while the slack lasts, rounded up by at most 2^-6. 16 bits.
struct MotionConstraint {
  uint16_t bits = 0;  // from the lowest: sensitivity (2), upper bits of the distance as a float (14)

  static MotionConstraint of(uint32_t sensitivity, float max_distance_m) {
    return {static_cast<uint16_t>((std::bit_cast<uint32_t>(max_distance_m) + 0x1ffff) >> 17 << 2 | sensitivity)};
  }
};

// What is known of a frontier node, except its slack: that its error is at least `bound` if it is in the section, at
// most `bound` if it is not (of a surface, whose records are known, no bound is kept), and its motion constraint. On a
// frontier that is swept there is no constraint, but whether the node is in the section, and whether it is left out as
// hidden.
struct FrontierEntry {
  uint32_t bits = 0;  // from the lowest: slot within the page (8), bound (8), constraint (16) or two flags

  static FrontierEntry of(uint8_t low, QuantisedError bound, MotionConstraint constraint) {
    return {low | uint32_t{bound.value} << 8 | uint32_t{constraint.bits} << 16};
  }
  // Of a node of whose error nothing is known but that it is not 0, for it is in the section; and that has any error.
  static FrontierEntry newLeaf(uint8_t low) { return of(low, {1}, {}); }
  static FrontierEntry newAddable(uint8_t low) { return of(low, {255}, {}); }

  enum class Stands : uint8_t { kOutside = 0, kInSection = 1, kHidden = 2 };
  static FrontierEntry swept(uint8_t low, QuantisedError bound, Stands stands) {
    return {low | uint32_t{bound.value} << 8 | static_cast<uint32_t>(stands) << 16};
  }

  // The same of another slot.
  FrontierEntry at(uint8_t other_low) const { return {(bits & ~0xffu) | other_low}; }

  uint8_t low() const { return static_cast<uint8_t>(bits); }
  QuantisedError bound() const { return {static_cast<uint8_t>(bits >> 8)}; }
  uint32_t sensitivity() const { return bits >> 16 & 3; }
  float maxDistance() const { return std::bit_cast<float>(bits >> 18 << 17); }
};
static_assert(sizeof(FrontierEntry) == 4);

class EntryPool {
 public:
  EntryPool() = default;
  // With memory for `entries`.
  explicit EntryPool(size_t entries) {
    slack_.reserve(entries);
    entries_.reserve(entries);
  }

  static constexpr uint32_t kVector = 8;                                // entries that are worked on at once
  static constexpr float kEndless = std::numeric_limits<float>::max();  // no motion takes anything off it
  // Entries by size of a block; 0 stands for no block.
  static constexpr std::array<uint16_t, 11> kSizes{0, 8, 16, 24, 32, 48, 64, 96, 128, 192, 256};

  struct Block {
    uint32_t first = 0;
    uint8_t size = 0;  // index into kSizes
  };

  float* slack(const Block& block) { return slack_.data() + block.first; }
  const float* slack(const Block& block) const { return slack_.data() + block.first; }
  FrontierEntry* entries(const Block& block) { return entries_.data() + block.first; }
  const FrontierEntry* entries(const Block& block) const { return entries_.data() + block.first; }
  float& slackAt(uint32_t index) { return slack_[index]; }
  FrontierEntry& entryAt(uint32_t index) { return entries_[index]; }
  const FrontierEntry& entryAt(uint32_t index) const { return entries_[index]; }

  // For a block that is read soon.
  void prefetch(const Block& block) const {
    __builtin_prefetch(slack_.data() + block.first);
    __builtin_prefetch(entries_.data() + block.first);
  }
  // Makes a block that holds `count` entries large enough for `wanted`.
  void reserve(Block& block, uint32_t count, uint32_t wanted);
  // Exchanges a block of which at most half is used by its first `count` entries for a smaller one.
  void shrink(Block& block, uint32_t count);

  // Entries for which blocks are taken, and for which there is memory.
  size_t held() const { return held_; }
  size_t capacity() const { return slack_.capacity(); }
  // Takes a block for the first `count` entries of another pool's block and copies them.
  Block copy(const EntryPool& from, const Block& block, uint32_t count);

  size_t bytes() const { return slack_.capacity() * sizeof(float) + entries_.capacity() * sizeof(FrontierEntry); }

 private:
  static constexpr uint32_t kNone = 0xffffffffu;

  void move(Block& block, uint32_t count, uint8_t size);
  Block take(uint8_t size);
  Block find(uint8_t size);
  void give(const Block& block);

  std::vector<float> slack_;
  std::vector<FrontierEntry> entries_;
  size_t held_ = 0;
  // The first free block of each size; the bits of a free block's first entry are the index of the next free block.
  std::array<uint32_t, kSizes.size()> free_ = [] {
    std::array<uint32_t, kSizes.size()> none{};
    none.fill(kNone);
    return none;
  }();
};

}  // namespace foreland::proto
