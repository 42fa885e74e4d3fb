// Where a frontier's entries live: in one pool, a block of it for each page that has entries. A block has two columns,
// what all entries are made of and then their slacks, or the rest of their heights on a frontier that is swept
// (sweep.h), so that a step is one pass of vector instructions over each. Blocks come in few sizes, all multiples of a
// vector, so a block that is given back fits others; what stands behind a block's last entry says nothing. One owner;
// grows by an eighth at a time, for a session's memory is counted.
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

// Whether the entries of a frontier have slacks, or are swept: all tested in each step.
enum class EntryKind : uint8_t { kSlack, kSwept };

// What is known of a frontier node: that its error is at least `bound` if it is in the section, at most `bound` if it
// is not (of a surface, whose records are known, no bound is kept). Beside it the motion that its last result survives:
// its slack and its motion constraint. On a frontier that is swept, instead, whether the node is in the section, and
// the height of its sphere, or that it is left out as hidden.
struct FrontierEntry {
  // From the lowest: slot within the page (8), bound (8), constraint (16); or, instead of the constraint, whether the
  // node is in the section (1), and the lower bits of the height (15).
  uint32_t bits = 0;
  uint32_t rest = 0;  // the slack as a float's bits; or the height's upper 8 bits

  static FrontierEntry of(uint8_t low, QuantisedError bound, MotionConstraint constraint, float slack) {
    return {low | uint32_t{bound.value} << 8 | uint32_t{constraint.bits} << 16, std::bit_cast<uint32_t>(slack)};
  }
  // Of a node of whose error nothing is known but that it is not 0, for it is in the section; and that has any error.
  // Without slack.
  static FrontierEntry newLeaf(uint8_t low) { return of(low, {1}, {}, 0); }
  static FrontierEntry newAddable(uint8_t low) { return of(low, {255}, {}, 0); }

  enum class Stands : uint8_t { kOutside, kInSection, kHidden };
  // Heights are those of a scene. Two values stand for something else: that it is not known, which what is out of range
  // becomes, and that the node is left out as hidden.
  static constexpr int32_t kUnknown = -(1 << 22), kHidden = kUnknown + 1, kLeastHeight = kHidden + 1;
  static FrontierEntry swept(uint8_t low, QuantisedError bound, Stands stands, int32_t height) {
    const bool is_known = height >= kLeastHeight && height < -kUnknown;
    const auto h = static_cast<uint32_t>(stands == Stands::kHidden ? kHidden : is_known ? height : kUnknown);
    return {low | uint32_t{bound.value} << 8 | (stands == Stands::kInSection ? 1u << 16 : 0u) | h << 17, h >> 15 & 255};
  }
  // From both parts of a swept entry.
  static int32_t heightOf(uint32_t bits, uint8_t upper) {
    return static_cast<int32_t>(static_cast<int8_t>(upper)) * (1 << 15) + static_cast<int32_t>(bits >> 17);
  }

  // The same of another slot.
  FrontierEntry at(uint8_t other_low) const { return {(bits & ~0xffu) | other_low, rest}; }

  uint8_t low() const { return static_cast<uint8_t>(bits); }
  QuantisedError bound() const { return {static_cast<uint8_t>(bits >> 8)}; }
  uint32_t sensitivity() const { return sensitivityOf(bits); }
  float maxDistance() const { return maxDistanceOf(bits); }
  static uint32_t sensitivityOf(uint32_t bits) { return bits >> 16 & 3; }
  static float maxDistanceOf(uint32_t bits) { return std::bit_cast<float>(bits >> 18 << 17); }
};

// A page's entries in the pool, and what their test needs of the page: 8 bytes, for each step reads those of all pages.
struct EntryBlock {
  uint32_t first = 0;      // in vectors of the pool
  uint16_t count = 0;      // of entries
  uint8_t size = 0;        // index into EntryPool::kSizes
  QuantisedRadius radius;  // of all nodes of the page; the owner's
};
static_assert(sizeof(EntryBlock) == 8);

class EntryPool {
 public:
  // With memory for `entries`.
  explicit EntryPool(EntryKind kind, size_t entries = 0)
      : kind_(kind), words_of_vector_(kind == EntryKind::kSlack ? 2 * kVector : kVector + kVector / 4) {
    words_.reserve(entries / kVector * words_of_vector_);
  }

  static constexpr uint32_t kVector = 8;                                // entries that are worked on at once
  static constexpr float kEndless = std::numeric_limits<float>::max();  // no motion takes anything off it
  // Entries by size of a block; 0 stands for no block.
  static constexpr std::array<uint16_t, 11> kSizes{0, 8, 16, 24, 32, 48, 64, 96, 128, 192, 256};

  EntryKind kind() const { return kind_; }
  // Columns of a block: FrontierEntry::bits, and of `rest` either slacks or the upper bits of heights.
  uint32_t* bits(const EntryBlock& block) { return words_.data() + size_t{block.first} * words_of_vector_; }
  const uint32_t* bits(const EntryBlock& block) const { return const_cast<EntryPool*>(this)->bits(block); }
  uint32_t* slacks(const EntryBlock& block) { return bits(block) + kSizes[block.size]; }
  uint8_t* heights(const EntryBlock& block) { return reinterpret_cast<uint8_t*>(slacks(block)); }
  const uint8_t* heights(const EntryBlock& block) const { return const_cast<EntryPool*>(this)->heights(block); }

  FrontierEntry at(const EntryBlock& block, uint32_t rank) const {
    const uint32_t* const b = bits(block);
    return {b[rank], kind_ == EntryKind::kSwept ? heights(block)[rank] : b[kSizes[block.size] + rank]};
  }
  void set(const EntryBlock& block, uint32_t rank, FrontierEntry entry) {
    bits(block)[rank] = entry.bits;
    if (kind_ == EntryKind::kSwept)
      heights(block)[rank] = static_cast<uint8_t>(entry.rest);
    else
      slacks(block)[rank] = entry.rest;
  }

  // For a block that is read soon.
  void prefetch(const EntryBlock& block) const {
    const uint32_t* const begin = bits(block);
    __builtin_prefetch(begin);
    __builtin_prefetch(begin + kSizes[block.size]);
  }
  // Makes a block large enough for `wanted` entries.
  void reserve(EntryBlock& block, uint32_t wanted);
  // Exchanges a block of which at most half is used for a smaller one.
  void shrink(EntryBlock& block);

  // Entries for which blocks are taken, and for which there is memory.
  size_t held() const { return held_; }
  size_t capacity() const { return words_.capacity() / words_of_vector_ * kVector; }
  // Entries for which copy() takes a block.
  static size_t heldByCopy(const EntryBlock& block);
  // Takes a block for the entries of another pool's block, of the same kind, and copies them.
  EntryBlock copy(const EntryPool& from, const EntryBlock& block);

  size_t bytes() const { return words_.capacity() * sizeof(uint32_t); }

 private:
  static constexpr uint32_t kNone = 0xffffffffu;

  void move(EntryBlock& block, uint8_t size);
  void copyEntries(const EntryPool& from, const EntryBlock& block, const EntryBlock& to);
  EntryBlock take(const EntryBlock& like, uint8_t size);
  EntryBlock find(uint8_t size);
  void give(const EntryBlock& block);

  EntryKind kind_;
  uint32_t words_of_vector_;
  std::vector<uint32_t> words_;
  size_t held_ = 0;
  // The first free block of each size; the first word of a free block is where the next free block begins.
  std::array<uint32_t, kSizes.size()> free_ = [] {
    std::array<uint32_t, kSizes.size()> none{};
    none.fill(kNone);
    return none;
  }();
};

}  // namespace foreland::proto
