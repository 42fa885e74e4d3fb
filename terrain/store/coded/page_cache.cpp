#include "terrain/store/coded/page_cache.h"

#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <thread>
#include <utility>

#include "base/check.h"

namespace foreland::terrain {

namespace {

Error fromSystem(const char* what) {
  return {ErrorCode::kLimit, std::string("the page cache: ") + what + ": " + std::strerror(errno) +
                                 "; give it less (--page-cache-mib), or build the scene with --pages plain"};
}

// Replaces what is mapped at an address, at once for all threads. By the system call itself, for ThreadSanitizer takes
// mmap() for a write to what others then read.
void mapOver(void* at, uint64_t bytes, int protection, int flags, int file, uint64_t offset) {
  const auto mapped = ::syscall(SYS_mmap, at, bytes, protection, flags | MAP_FIXED, file, static_cast<off_t>(offset));
  CHECK_EQ(reinterpret_cast<void*>(mapped), at);
}

// Each held group may split the addresses around it in two.
uint64_t mostFrames() {
  uint64_t mappings = 65530;
  std::ifstream("/proc/sys/vm/max_map_count") >> mappings;
  constexpr uint64_t kOfOthers = 4096;
  return mappings > 2 * kOfOthers ? (mappings - kOfOthers) / 2 : kOfOthers / 2;
}

}  // namespace

uint64_t PageCache::leastBytes(uint64_t group_bytes) {
  return group_bytes * kFramesForAThread * std::max(1u, std::thread::hardware_concurrency());
}

Result<std::unique_ptr<PageCache>> PageCache::create(const Size& size, Inflate inflate) {
  const auto page = static_cast<uint64_t>(::sysconf(_SC_PAGESIZE));
  if (size.group_bytes % page != 0)
    return Error{ErrorCode::kUnsupported, "the page cache: this system's pages of " + std::to_string(page) +
                                              " bytes are too large; build the scene with --pages plain"};
  std::unique_ptr<PageCache> cache(new PageCache(size, std::move(inflate)));
  if (Status s = cache->reserve(); !s.ok()) return s.error();
  return cache;
}

Status PageCache::reserve() {
  const uint64_t groups = (size_.bytes + size_.group_bytes - 1) / size_.group_bytes;
  const uint64_t wanted = std::max(size_.cache_bytes, leastBytes(size_.group_bytes)) / size_.group_bytes;
  // No more than there are groups, and those that threads hold while they inflate.
  const uint64_t frames = std::min(
      {wanted, groups + leastBytes(size_.group_bytes) / size_.group_bytes, std::max<uint64_t>(mostFrames(), 1)});
  reserved_ = std::max<uint64_t>(groups, 1) * size_.group_bytes;
  void* data = ::mmap(nullptr, reserved_, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (data == MAP_FAILED) return fromSystem("no addresses for the scene's pages");
  data_ = static_cast<uint8_t*>(data);
  memory_ = ::memfd_create("foreland-pages", MFD_CLOEXEC);
  if (memory_ < 0 || ::ftruncate(memory_, static_cast<off_t>(frames * size_.group_bytes)) != 0)
    return fromSystem("no memory");
  void* memory = ::mmap(nullptr, frames * size_.group_bytes, PROT_READ | PROT_WRITE, MAP_SHARED, memory_, 0);
  if (memory == MAP_FAILED) return fromSystem("no addresses");
  frames_data_ = static_cast<uint8_t*>(memory);
  frame_of_.assign(groups, kNone);
  frames_.resize(frames);
  free_.resize(frames);
  for (uint32_t i = 0; i < frames; ++i) free_[i] = static_cast<uint32_t>(frames) - 1 - i;
  counts_.frames = frames;
  region_ = std::make_unique<TouchRegion>(data_, reserved_, *this);
  return {};
}

PageCache::~PageCache() {
  region_.reset();
  if (data_) ::munmap(data_, reserved_);
  if (frames_data_) ::munmap(frames_data_, frames_.size() * size_.group_bytes);
  if (memory_ >= 0) ::close(memory_);
}

PageCache::Counts PageCache::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

namespace {

// How many groups this thread is inflating, each for the one before it.
thread_local uint32_t inflating = 0;

}  // namespace

void PageCache::onTouch(uintptr_t address) {
  const uint64_t group = (address - reinterpret_cast<uintptr_t>(data_)) / size_.group_bytes;
  if (wake(group)) return;
  const uint64_t most_threads = std::max<uint64_t>(frames_.size() / kFramesForAThread, 1);
  if (inflating == 0)
    for (uint64_t now = threads_inflating_;
         now >= most_threads || !threads_inflating_.compare_exchange_weak(now, now + 1); now = threads_inflating_)
      std::this_thread::yield();
  ++inflating;
  makeReadable(group);
  if (--inflating == 0) --threads_inflating_;
}

void PageCache::makeReadable(uint64_t group) {
  const uint32_t frame = takeFrame();
  const uint64_t bytes = std::min(size_.group_bytes, size_.bytes - group * size_.group_bytes);
  inflate_(group, {memoryOf(frame), bytes});
  publish(group, frame);
}

// Whether the group was held.
bool PageCache::wake(uint64_t group) {
  const std::lock_guard lock(mutex_);
  const uint32_t frame = frame_of_[group];
  if (frame == kNone) return false;
  Frame& held = frames_[frame];
  if (!held.is_resting) return true;
  protect(group, PROT_READ);
  held.is_resting = false;
  dequeue(resting_, frame);
  enqueue(active_, frame);
  ++counts_.woken;
  restTheOldest();
  return true;
}

uint32_t PageCache::takeFrame() {
  for (;; std::this_thread::yield()) {
    const std::lock_guard lock(mutex_);
    if (!free_.empty()) {
      const uint32_t frame = free_.back();
      free_.pop_back();
      return frame;
    }
    if (const uint32_t frame = evictTheOldest(); frame != kNone) return frame;
  }
}

uint32_t PageCache::evictTheOldest() {
  Queue& from = resting_.count == 0 ? active_ : resting_;
  const uint32_t frame = from.oldest;
  if (frame == kNone) return kNone;
  dequeue(from, frame);
  const uint64_t group = frames_[frame].group;
  mapOver(addressOf(group), size_.group_bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  frame_of_[group] = kNone;
  --counts_.held;
  ++counts_.evicted;
  return frame;
}

void PageCache::publish(uint64_t group, uint32_t frame) {
  const std::lock_guard lock(mutex_);
  ++counts_.inflated;
  if (frame_of_[group] != kNone) return free_.push_back(frame);  // it has the capacity
  mapOver(addressOf(group), size_.group_bytes, PROT_READ, MAP_SHARED | MAP_POPULATE, memory_,
          uint64_t{frame} * size_.group_bytes);
  frame_of_[group] = frame;
  frames_[frame].group = group;
  frames_[frame].is_resting = false;
  enqueue(active_, frame);
  ++counts_.held;
  restTheOldest();
}

// Once all frames are used, a quarter of them rest.
void PageCache::restTheOldest() {
  if (!free_.empty()) return;
  while (resting_.count < frames_.size() / 4 && active_.count > 1) {
    const uint32_t frame = active_.oldest;
    protect(frames_[frame].group, PROT_NONE);
    frames_[frame].is_resting = true;
    dequeue(active_, frame);
    enqueue(resting_, frame);
  }
}

void PageCache::enqueue(Queue& queue, uint32_t frame) {
  frames_[frame].before = queue.newest;
  frames_[frame].after = kNone;
  (queue.newest == kNone ? queue.oldest : frames_[queue.newest].after) = frame;
  queue.newest = frame;
  ++queue.count;
}

void PageCache::dequeue(Queue& queue, uint32_t frame) {
  const auto [before, after] = std::pair(frames_[frame].before, frames_[frame].after);
  (before == kNone ? queue.oldest : frames_[before].after) = after;
  (after == kNone ? queue.newest : frames_[after].before) = before;
  --queue.count;
}

void PageCache::protect(uint64_t group, int protection) const {
  CHECK_EQ(::mprotect(addressOf(group), size_.group_bytes, protection), 0);
}

}  // namespace foreland::terrain
