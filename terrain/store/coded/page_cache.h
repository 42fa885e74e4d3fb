// The groups of pages that were touched last, inflated, at the addresses where they would be if all were: readers have
// a plain array, of which the parts that are not held cannot be read and are inflated by whoever touches one
// (touch_regions.h). So a reader pays nothing for the cache, holds nothing while it reads, and never sees a part that
// is half there or that belongs to another group: the system takes the address away from all threads before the memory
// behind it is used again, and a load that comes later makes the group anew.
//
// Memory is a number of frames, taken once. Which group goes is found without looking at loads, as in VMS (Turner and
// Levy 1981, segmented FIFO): a quarter of the groups, those that have been readable the longest, rest; they are
// held but cannot be read. A touch makes a resting group readable again without inflating it; the group that has rested
// the longest goes. Nothing rests before all frames are used.
//
// Any thread may read and touch. The lock is taken at touches alone and never while something inflates; threads that
// touch the same group at once each inflate it, and one copy stays. No more threads inflate at a time than there are
// frames for; others wait for these.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "base/result.h"
#include "terrain/store/coded/touch_regions.h"

namespace foreland::terrain {

class PageCache final : public TouchOwner {
 public:
  // Fills the bytes of a group; the last group may be short. Called by several threads at once, in a signal handler;
  // may read groups of smaller numbers from the cache.
  using Inflate = std::function<void(uint64_t group, std::span<uint8_t> out)>;

  struct Size {
    uint64_t bytes = 0;        // of all groups
    uint64_t group_bytes = 0;  // a multiple of the system's pages
    uint64_t cache_bytes = 0;  // rounded up to leastBytes()
  };
  // A thread holds a frame for each level that it inflates at a time.
  static constexpr uint64_t kFramesForAThread = 64;
  static uint64_t leastBytes(uint64_t group_bytes);

  // An Error if the system has no addresses or memory for it.
  static Result<std::unique_ptr<PageCache>> create(const Size& size, Inflate inflate);
  PageCache(const PageCache&) = delete;
  PageCache& operator=(const PageCache&) = delete;
  ~PageCache();

  std::span<const uint8_t> bytes() const { return {data_, size_.bytes}; }

  struct Counts {
    uint64_t frames = 0;    // there are
    uint64_t held = 0;      // groups, of which some rest
    uint64_t inflated = 0;  // since the start, with those that another thread was quicker with
    uint64_t woken = 0;     // resting groups that were touched
    uint64_t evicted = 0;
  };
  Counts counts() const;

 private:
  static constexpr uint32_t kNone = ~uint32_t{0};
  struct Frame {
    uint64_t group = 0;
    bool is_resting = false;
    uint32_t before = kNone, after = kNone;  // in its queue
  };
  // Frames, linked: nothing is allocated in a signal handler.
  struct Queue {
    uint32_t oldest = kNone, newest = kNone;
    uint64_t count = 0;
  };

  PageCache(const Size& size, Inflate inflate) : size_(size), inflate_(std::move(inflate)) {}
  Status reserve();
  void onTouch(uintptr_t address) override;
  void makeReadable(uint64_t group);
  bool wake(uint64_t group);
  uint32_t takeFrame();
  void publish(uint64_t group, uint32_t frame);
  void enqueue(Queue& queue, uint32_t frame);
  void dequeue(Queue& queue, uint32_t frame);
  void restTheOldest();
  uint32_t evictTheOldest();
  void protect(uint64_t group, int protection) const;
  uint8_t* addressOf(uint64_t group) const { return data_ + group * size_.group_bytes; }
  uint8_t* memoryOf(uint32_t frame) const { return frames_data_ + frame * size_.group_bytes; }

  Size size_;
  Inflate inflate_;
  uint64_t reserved_ = 0;
  int memory_ = -1;                 // the frames, as a file
  uint8_t* data_ = nullptr;         // where readers see them
  uint8_t* frames_data_ = nullptr;  // where they are filled

  std::atomic<uint64_t> threads_inflating_{0};

  mutable std::mutex mutex_;        // of all below
  std::vector<uint32_t> frame_of_;  // by group; kNone if it is not held
  std::vector<Frame> frames_;
  std::vector<uint32_t> free_;
  Queue active_, resting_;  // frames whose groups can be read, and those whose cannot
  Counts counts_;
  std::unique_ptr<TouchRegion> region_;
};

}  // namespace foreland::terrain
