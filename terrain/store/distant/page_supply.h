// Which of a scene's pages and tiles are there, of a scene at a distance (chunk_cache.h), and what their bytes are
// called. Immutable but for the cache; any thread.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "proto/section/bounds.h"
#include "proto/section/page_directory.h"
#include "terrain/store/distant/chunk_cache.h"
#include "terrain/store/file/sections.h"

namespace foreland::terrain {

class PageSupply {
 public:
  // Of a file whose records of nodes lie where `nodes` says, as they are in memory.
  PageSupply(std::shared_ptr<ChunkCache> cache, const SectionRange& nodes) : cache_(std::move(cache)), nodes_(nodes) {}

  ChunkCache& cache() const { return *cache_; }
  // Of the page of a place (PageDirectory::placeOf); pages do not straddle chunks.
  ChunkCache::Chunk chunkOf(uint64_t place) const {
    return cache_->chunkAt(nodes_.offset + place * sizeof(proto::NodeRecord));
  }
  // Copies a record, or returns false if it is not there.
  bool read(std::span<const proto::NodeRecord> records, uint64_t place, proto::NodeRecord& record) const {
    const ChunkCache::Chunk chunk = chunkOf(place);
    if (!cache_->hold(chunk)) return false;
    record = records[place];
    cache_->release(chunk);
    return true;
  }

  // Calls use() while some of the file's bytes are there, from `offset` in it on; returns false if they are not, and
  // appends what lacks to `wishes`.
  template <class Use>
  bool use(uint64_t offset, uint64_t bytes, float error_px, std::vector<ChunkCache::Wish>& wishes,
           const Use& use) const {
    const ChunkCache::Chunk first = cache_->chunkAt(offset),
                            last = cache_->chunkAt(offset + (bytes > 0 ? bytes - 1 : 0));
    bool are_there = true;
    std::vector<ChunkCache::Chunk> held;
    for (ChunkCache::Chunk chunk = first; chunk <= last; ++chunk)
      if (cache_->hold(chunk))
        held.push_back(chunk);
      else {
        are_there = false;
        wishes.push_back({chunk, error_px});
      }
    if (are_there) use();
    for (const ChunkCache::Chunk chunk : held) cache_->release(chunk);
    return are_there;
  }

 private:
  std::shared_ptr<ChunkCache> cache_;
  SectionRange nodes_;
};

}  // namespace foreland::terrain
