// Memory that viewers leave behind goes back to the system: the allocator would keep it for those who may come. Not
// often, for that takes milliseconds, and who comes next takes as long to get it. One owner.
#pragma once

#include <cstddef>

#include "base/time.h"

namespace foreland::server {

class MemoryReturn {
 public:
  static constexpr Duration kMinInterval = Duration::seconds(2);

  // To be asked from time to time. True if so many viewers are fewer by a quarter than there have been since the last
  // time that it was true.
  bool isDue(size_t viewers, Time now);
  // To be called once, before there are other threads. Large blocks, those of sections above all, lie by themselves
  // from then on and go back as soon as they are given up; a section that grows leaves no hole behind.
  static void prepare();
  // Any thread. Some 10 ms for 100 MB.
  static void run();

 private:
  size_t most_ = 0;  // viewers
  Time last_;
};

}  // namespace foreland::server
