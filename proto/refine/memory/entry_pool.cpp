#include "proto/refine/memory/entry_pool.h"

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

void EntryPool::reserve(Block& block, uint32_t count, uint32_t wanted) {
  if (wanted > kSizes[block.size]) move(block, count, sizeFor(wanted));
}

void EntryPool::shrink(Block& block, uint32_t count) {
  if (count == 0 || (block.size > 1 && 2 * count <= kSizes[block.size])) move(block, count, sizeFor(count + count / 4));
}

void EntryPool::move(Block& block, uint32_t count, uint8_t size) {
  if (size == block.size) return;
  Block next;
  if (size != 0) {
    next = take(size);
    if (size < block.size && next.size >= block.size) return give(next);  // no smaller one is free
    std::fill(std::copy_n(slack(block), count, slack(next)), slack(next) + kSizes[next.size], kEndless);
    std::copy_n(entries(block), count, entries(next));
  }
  if (block.size != 0) give(block);
  block = next;
}

EntryPool::Block EntryPool::copy(const EntryPool& from, const Block& block, uint32_t count) {
  if (count == 0) return {};
  const Block to = take(sizeFor(count));
  std::fill(std::copy_n(from.slack_.data() + block.first, count, slack(to)), slack(to) + kSizes[to.size], kEndless);
  std::copy_n(from.entries(block), count, entries(to));
  return to;
}

EntryPool::Block EntryPool::take(uint8_t size) {
  const Block block = find(size);
  held_ += kSizes[block.size];
  return block;
}

// A free block of this size or one of the next two, else a new one.
EntryPool::Block EntryPool::find(uint8_t size) {
  for (uint8_t s = size; s < kSizes.size() && s <= size + 2; ++s) {
    if (free_[s] == kNone) continue;
    const Block block{free_[s], s};
    free_[s] = entries(block)->bits;
    return block;
  }
  const Block block{static_cast<uint32_t>(slack_.size()), size};
  resizeByEighths(slack_, slack_.size() + kSizes[size], kEndless);
  resizeByEighths(entries_, entries_.size() + kSizes[size], FrontierEntry{});
  return block;
}

void EntryPool::give(const Block& block) {
  held_ -= kSizes[block.size];
  entries(block)->bits = free_[block.size];
  free_[block.size] = block.first;
}

}  // namespace foreland::proto
