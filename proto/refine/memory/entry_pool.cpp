#include "proto/refine/memory/entry_pool.h"

namespace foreland::proto {

namespace {

constexpr auto kSizeForVectors = [] {
  std::array<uint8_t, 256 / EntryPool::kVector + 1> sizes{};
  for (uint32_t vectors = 0; vectors < sizes.size(); ++vectors)
    while (EntryPool::kSizes[sizes[vectors]] < vectors * EntryPool::kVector) ++sizes[vectors];
  return sizes;
}();

uint8_t sizeFor(uint32_t count) { return kSizeForVectors[(count + EntryPool::kVector - 1) / EntryPool::kVector]; }

}  // namespace

void EntryPool::reserve(EntryBlock& block, uint32_t wanted) {
  if (wanted > kSizes[block.size]) move(block, sizeFor(wanted));
}

void EntryPool::shrink(EntryBlock& block) {
  const uint32_t count = block.count;
  if (count == 0 || (block.size > 1 && 2 * count <= kSizes[block.size])) move(block, sizeFor(count + count / 4));
}

void EntryPool::move(EntryBlock& block, uint8_t size) {
  if (size == block.size) return;
  EntryBlock next = block;
  next.size = 0;
  if (size != 0) {
    next = take(block, size);
    if (size < block.size && next.size >= block.size) return give(next);  // no smaller one is free
    copyEntries(*this, block, next);
  }
  if (block.size != 0) give(block);
  block = next;
}

size_t EntryPool::heldByCopy(const EntryBlock& block) { return kSizes[sizeFor(block.count)]; }

EntryBlock EntryPool::copy(const EntryPool& from, const EntryBlock& block) {
  EntryBlock to = block;
  to.size = 0;
  if (block.count == 0) return to;
  to = take(block, sizeFor(block.count));
  copyEntries(from, block, to);
  return to;
}

void EntryPool::copyEntries(const EntryPool& from, const EntryBlock& block, const EntryBlock& to) {
  std::copy_n(from.bits(block), block.count, bits(to));
  if (kind_ == EntryKind::kSwept)
    std::copy_n(from.heights(block), block.count, heights(to));
  else
    std::copy_n(from.bits(block) + kSizes[block.size], block.count, slacks(to));
}

EntryBlock EntryPool::take(const EntryBlock& like, uint8_t size) {
  EntryBlock block = find(size);
  block.count = like.count;
  block.radius = like.radius;
  held_ += kSizes[block.size];
  return block;
}

// A free block of this size or one of the next two, else a new one.
EntryBlock EntryPool::find(uint8_t size) {
  EntryBlock block;
  for (uint8_t s = size; s < kSizes.size() && s <= size + 2; ++s) {
    if (free_[s] == kNone) continue;
    block.first = free_[s];
    block.size = s;
    free_[s] = *bits(block);
    return block;
  }
  block.first = static_cast<uint32_t>(words_.size() / words_of_vector_);
  block.size = size;
  const size_t words = words_.size() + kSizes[size] / kVector * words_of_vector_;
  if (words > words_.capacity()) words_.reserve(words + words / 8);
  words_.resize(words);
  return block;
}

void EntryPool::give(const EntryBlock& block) {
  held_ -= kSizes[block.size];
  *bits(block) = free_[block.size];
  free_[block.size] = block.first;
}

}  // namespace foreland::proto
