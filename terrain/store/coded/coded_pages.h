// The records of a scene whose pages are coded (group_codec.h), as the array that they are in a scene whose are not:
// what is touched is inflated, into memory of a bounded size (page_cache.h). docs/SCENE_FORMAT.md describes the
// section. Immutable for those who read; any thread.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "terrain/store/coded/group_codec.h"
#include "terrain/store/coded/page_cache.h"

namespace foreland::terrain {

inline constexpr uint64_t kDefaultPageCacheBytes = uint64_t{256} << 20;

// The section of coded pages: a u64 for each group that says where its bytes end, and one that says where the start of
// models does; the start; the groups' bytes. All ends count from the start on. A view.
class CodedSection {
 public:
  CodedSection(ByteSpan bytes, uint64_t groups) : bytes_(bytes), groups_(groups) {}

  static uint64_t tableBytes(uint64_t groups) { return (groups + 1) * sizeof(uint64_t); }
  uint64_t bytes() const { return bytes_.size(); }
  uint64_t groups() const { return groups_; }
  // Whether its table is there.
  bool isWhole() const { return bytes_.size() >= tableBytes(groups_); }
  ByteSpan start() const { return part(0); }
  // Nothing if the table is damaged there.
  ByteSpan group(uint64_t index) const { return part(index + 1); }

 private:
  ByteSpan part(uint64_t index) const;

  ByteSpan bytes_;
  uint64_t groups_;
};

class CodedPages {
 public:
  // `terrain` without its records, and the section, must outlive it.
  static Result<std::unique_ptr<CodedPages>> open(const CodedTerrain& terrain, ByteSpan section,
                                                  uint64_t page_cache_bytes);

  // By place. Valid as long as this is.
  std::span<const proto::NodeRecord> records() const { return terrain_.records; }
  PageCache::Counts counts() const { return cache_->counts(); }
  uint64_t codedBytes() const { return section_.bytes(); }
  // Groups that were touched and are damaged. Their records are zeros, so nothing is refined there.
  uint64_t damagedGroups() const { return damaged_.load(std::memory_order_relaxed); }

 private:
  CodedPages(const CodedTerrain& terrain, CodedSection section) : terrain_(terrain), section_(section) {}
  void inflate(uint64_t group, std::span<uint8_t> out);
  void reserveModels();
  PageModel* takeModel();
  void giveBack(PageModel* model);

  CodedTerrain terrain_;
  CodedSection section_;
  ModelStart start_;
  std::unique_ptr<PageCache> cache_;
  std::atomic<uint64_t> damaged_{0};
  std::mutex mutex_;                           // of the models
  std::unique_ptr<std::byte[]> model_memory_;  // not all of it is ever touched
  std::vector<PageModel*> free_models_;
};

}  // namespace foreland::terrain
