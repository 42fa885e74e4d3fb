// Where a frontier's entries live: in rooms of one pool, a room for each page that has entries, in two columns, so that
// a step's motion is one pass of vector instructions over each. Rooms come in few sizes, all multiples of a vector, so
// those that are given back are of use to others; a slack behind a room's last entry is endless. One owner; grows by an
// eighth at a time, for a session's memory is counted.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <vector>

#include "proto/refine/metric.h"
#include "proto/section/bounds.h"

namespace foreland::proto {

// What is known of a frontier node's error: that it is at least `bound` if the node is active, at most if it is not.
// And what its slack, which stands apart, is held to: by which guard (Metric::TestResult), and how far from the eye the
// node can be at most while it lasts.
struct Entry {
  uint32_t bits = 0;  // from the lowest: slot within the page (8), bound (8), guard (2), reach rounded up (14)

  static Entry of(uint8_t low, QuantisedError bound, uint16_t constraint) {
    return {low | uint32_t{bound.value} << 8 | uint32_t{constraint} << 16};
  }
  uint8_t low() const { return static_cast<uint8_t>(bits); }
  QuantisedError bound() const { return {static_cast<uint8_t>(bits >> 8)}; }
  uint32_t sensitivity() const { return bits >> 16 & 3; }
  float max_distance() const { return std::bit_cast<float>(bits >> 18 << 17); }
  void setConstraint(uint16_t constraint) { bits = (bits & 0xffff) | uint32_t{constraint} << 16; }

  // The upper half of an entry.
  static uint16_t constraint(float max_distance, uint32_t sensitivity) {
    return static_cast<uint16_t>((std::bit_cast<uint32_t>(max_distance) + 0x1ffff) >> 17 << 2 | sensitivity);
  }
};
static_assert(sizeof(Entry) == 4);

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
  // Entries by size of room; 0 stands for no room.
  static constexpr std::array<uint16_t, 11> kSizes{0, 8, 16, 24, 32, 48, 64, 96, 128, 192, 256};

  struct Block {
    uint32_t first = 0;
    uint8_t size = 0;  // of kSizes
  };

  float* slack(const Block& block) { return slack_.data() + block.first; }
  Entry* entries(const Block& block) { return entries_.data() + block.first; }
  const Entry* entries(const Block& block) const { return entries_.data() + block.first; }
  float& slackAt(uint32_t place) { return slack_[place]; }
  Entry& entryAt(uint32_t place) { return entries_[place]; }
  const Entry& entryAt(uint32_t place) const { return entries_[place]; }

  // The room is wanted soon.
  void prefetch(const Block& block) const {
    __builtin_prefetch(slack_.data() + block.first);
    __builtin_prefetch(entries_.data() + block.first);
  }
  // Block for `wanted`, of which `count` are there.
  void reserve(Block& block, uint32_t count, uint32_t wanted);
  // Puts an entry at place `at` of `count`, or takes it out.
  void insert(Block& block, uint32_t count, uint32_t at, float slack, Entry entry);
  void erase(Block& block, uint32_t count, uint32_t at);

  // Entries in rooms that are held, and in memory.
  size_t held() const { return held_; }
  size_t capacity() const { return slack_.capacity(); }
  // Takes a room for the first `count` entries of another pool's.
  Block copy(const EntryPool& from, const Block& block, uint32_t count);

  size_t bytes() const { return slack_.capacity() * sizeof(float) + entries_.capacity() * sizeof(Entry); }

 private:
  static constexpr uint32_t kNone = 0xffffffffu;

  void move(Block& block, uint32_t count, uint8_t size);
  Block take(uint8_t size);
  Block find(uint8_t size);
  void give(const Block& block);

  std::vector<float> slack_;
  std::vector<Entry> entries_;
  size_t held_ = 0;
  // The first free room of each size; its first entry's bits are the place of the next.
  std::array<uint32_t, kSizes.size()> free_ = [] {
    std::array<uint32_t, kSizes.size()> none{};
    none.fill(kNone);
    return none;
  }();
};

}  // namespace foreland::proto
