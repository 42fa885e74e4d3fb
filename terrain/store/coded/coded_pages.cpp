#include "terrain/store/coded/coded_pages.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <thread>

namespace foreland::terrain {

ByteSpan CodedSection::part(uint64_t index) const {
  const auto endOf = [&](uint64_t i) {
    uint64_t end = 0;
    std::memcpy(&end, bytes_.data() + i * sizeof(end), sizeof(end));
    return end;
  };
  const ByteSpan coded = bytes_.subspan(tableBytes(groups_));
  const uint64_t begin = index == 0 ? 0 : endOf(index - 1), end = endOf(index);
  return begin <= end && end <= coded.size() ? coded.subspan(begin, end - begin) : ByteSpan();
}

Result<std::unique_ptr<CodedPages>> CodedPages::open(const CodedTerrain& terrain, ByteSpan section,
                                                     uint64_t page_cache_bytes) {
  const uint64_t pages = terrain.directory.pageCount();
  const CodedSection coded(section, groupCount(pages));
  if (!coded.isWhole()) return Error{ErrorCode::kMalformed, "its coded pages are cut short"};
  std::unique_ptr<CodedPages> made(new CodedPages(terrain, coded));
  if (!made->start_.decode(coded.start()))
    return Error{ErrorCode::kMalformed, "it does not say how its pages are coded"};
  made->reserveModels();
  auto cache =
      PageCache::create({.bytes = pages * proto::kPageSlots * sizeof(proto::NodeRecord),
                         .group_bytes = kGroupBytes,
                         .cache_bytes = page_cache_bytes},
                        [self = made.get()](uint64_t group, std::span<uint8_t> out) { self->inflate(group, out); });
  if (!cache) return cache.error();
  made->cache_ = std::move(*cache);
  const std::span<const uint8_t> bytes = made->cache_->bytes();
  made->terrain_.records = {reinterpret_cast<const proto::NodeRecord*>(bytes.data()),
                            bytes.size() / sizeof(proto::NodeRecord)};
  return made;
}

void CodedPages::inflate(uint64_t group, std::span<uint8_t> out) {
  PageModel* model = takeModel();
  start_.apply(*model);
  const std::span<proto::NodeRecord> records(reinterpret_cast<proto::NodeRecord*>(out.data()),
                                             out.size() / sizeof(proto::NodeRecord));
  const ByteSpan bytes = section_.group(group);
  if (bytes.empty() || !decodeGroup(terrain_, group, bytes, *model, records)) {
    std::ranges::fill(records, proto::NodeRecord{});
    damaged_.fetch_add(1, std::memory_order_relaxed);
  }
  giveBack(model);
}

// One for each group that threads can inflate at a time, for no memory is allocated in a signal handler.
void CodedPages::reserveModels() {
  const uint64_t models = PageCache::leastBytes(1);
  model_memory_.reset(new std::byte[models * sizeof(PageModel)]);
  for (uint64_t i = models; i-- > 0;)
    free_models_.push_back(reinterpret_cast<PageModel*>(model_memory_.get() + i * sizeof(PageModel)));
}

PageModel* CodedPages::takeModel() {
  for (;; std::this_thread::yield()) {
    const std::lock_guard lock(mutex_);
    if (free_models_.empty()) continue;
    PageModel* model = free_models_.back();
    free_models_.pop_back();
    return new (model) PageModel;
  }
}

void CodedPages::giveBack(PageModel* model) {
  const std::lock_guard lock(mutex_);
  free_models_.push_back(model);
}

}  // namespace foreland::terrain
