#include "proto/refine/entry_pool.h"

namespace foreland::proto {

namespace {

uint8_t sizeFor(uint32_t count) {
  uint8_t size = 0;
  while (EntryPool::kSizes[size] < count) ++size;
  return size;
}

template <class T>
void resizeByEighths(std::vector<T>& v, size_t size, T value) {
  if (size > v.capacity()) v.reserve(size + size / 8);
  v.resize(size, value);
}

}  // namespace

void EntryPool::reserve(Room& room, uint32_t count, uint32_t wanted) {
  if (wanted > kSizes[room.size]) move(room, count, sizeFor(wanted));
}

void EntryPool::insert(Room& room, uint32_t count, uint32_t at, float slack, Entry entry) {
  reserve(room, count, count + 1);
  float* s = this->slack(room);
  Entry* e = entries(room);
  std::copy_backward(s + at, s + count, s + count + 1);
  std::copy_backward(e + at, e + count, e + count + 1);
  s[at] = slack;
  e[at] = entry;
}

// A room that is half empty is left for a smaller one.
void EntryPool::erase(Room& room, uint32_t count, uint32_t at) {
  float* s = slack(room);
  Entry* e = entries(room);
  std::copy(s + at + 1, s + count, s + at);
  std::copy(e + at + 1, e + count, e + at);
  const uint32_t left = count - 1;
  s[left] = kEndless;
  if (left == 0 || (room.size > 1 && 2 * left <= kSizes[room.size])) move(room, left, sizeFor(left + left / 4));
}

void EntryPool::move(Room& room, uint32_t count, uint8_t size) {
  if (size == room.size) return;
  Room next;
  if (size != 0) {
    next = take(size);
    if (count < kSizes[room.size] && next.size >= room.size) return give(next);  // no smaller one to be had
    std::fill(std::copy_n(slack(room), count, slack(next)), slack(next) + kSizes[next.size], kEndless);
    std::copy_n(entries(room), count, entries(next));
  }
  if (room.size != 0) give(room);
  room = next;
}

EntryPool::Room EntryPool::copy(const EntryPool& from, const Room& room, uint32_t count) {
  if (count == 0) return {};
  const Room to = take(sizeFor(count));
  std::fill(std::copy_n(from.slack_.data() + room.first, count, slack(to)), slack(to) + kSizes[to.size], kEndless);
  std::copy_n(from.entries(room), count, entries(to));
  return to;
}

EntryPool::Room EntryPool::take(uint8_t size) {
  const Room room = find(size);
  held_ += kSizes[room.size];
  return room;
}

// If none is free, one of the next two sizes, before the pool grows.
EntryPool::Room EntryPool::find(uint8_t size) {
  for (uint8_t s = size; s < kSizes.size() && s <= size + 2; ++s) {
    if (free_[s] == kNone) continue;
    const Room room{free_[s], s};
    free_[s] = entries(room)->bits;
    return room;
  }
  const Room room{static_cast<uint32_t>(slack_.size()), size};
  resizeByEighths(slack_, slack_.size() + kSizes[size], kEndless);
  resizeByEighths(entries_, entries_.size() + kSizes[size], Entry{});
  return room;
}

void EntryPool::give(const Room& room) {
  held_ -= kSizes[room.size];
  entries(room)->bits = free_[room.size];
  free_[room.size] = room.first;
}

}  // namespace foreland::proto
