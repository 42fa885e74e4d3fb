// Which coded tiles a client holds. Server and client apply the same rule to the same tiles in the same order, so the
// server knows without a message what the client has dropped: the oldest, once there are more than fit. One owner.
#pragma once

#include <cstdint>
#include <deque>
#include <unordered_map>

#include "proto/imagery/tile.h"

namespace foreland::proto {

inline constexpr size_t kMaxTilesHeld = 4096;
inline constexpr uint32_t kDefaultTileBytes = 64u << 20;

class TileMemory {
 public:
  explicit TileMemory(uint32_t max_bytes = kDefaultTileBytes) : max_bytes_(max_bytes) {}

  // Takes a tile of so many bytes, and drops the oldest until what is held fits; calls `drop(id)` for each. The newest
  // is always held. A tile that is held already becomes the newest.
  template <class Drop>
  void add(const TileId& tile, uint32_t bytes, const Drop& drop) {
    if (const auto held = held_.find(tile.key()); held != held_.end()) bytes_ -= held->second.bytes;
    held_[tile.key()] = {bytes, ++newest_};
    order_.push_back({tile.key(), newest_});
    bytes_ += bytes;
    while (held_.size() > 1 && (bytes_ > max_bytes_ || held_.size() > kMaxTilesHeld)) dropOldest(drop);
    if (order_.size() > 2 * held_.size() + 16) compact();
  }

  bool has(const TileId& tile) const { return held_.contains(tile.key()); }
  size_t count() const { return held_.size(); }
  uint64_t bytes() const { return bytes_; }
  // Calls visit(id, bytes) for what is held, the oldest first.
  template <class Visit>
  void visit(const Visit& visit) const {
    for (const Entry& e : order_)
      if (isCurrent(e)) visit(TileId::of(e.key), held_.at(e.key).bytes);
  }

 private:
  struct Held {
    uint32_t bytes;
    uint64_t number;
  };
  struct Entry {
    uint64_t key, number;
  };
  bool isCurrent(const Entry& e) const {
    const auto held = held_.find(e.key);
    return held != held_.end() && held->second.number == e.number;
  }
  template <class Drop>
  void dropOldest(const Drop& drop) {
    while (!isCurrent(order_.front())) order_.pop_front();
    const uint64_t key = order_.front().key;
    order_.pop_front();
    bytes_ -= held_.at(key).bytes;
    held_.erase(key);
    drop(TileId::of(key));
  }
  void compact() {
    std::erase_if(order_, [&](const Entry& e) { return !isCurrent(e); });
  }

  uint64_t max_bytes_;
  uint64_t bytes_ = 0, newest_ = 0;
  std::unordered_map<uint64_t, Held> held_;
  std::deque<Entry> order_;  // oldest first; tiles that became newer are in it twice
};

}  // namespace foreland::proto
