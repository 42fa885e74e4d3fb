// The faults that a check of a file finds. Threads: add() may be called by several at once.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "terrain/store/file/sections.h"

namespace foreland::terrain {

// Counts faults and keeps the first of them in the file's order.
class Faults {
 public:
  void add(uint64_t order, std::string what);
  uint64_t count() const { return count_; }
  std::vector<std::string> first() const;

 private:
  std::mutex mutex_;
  uint64_t count_ = 0;
  std::vector<std::pair<uint64_t, std::string>> first_;
};

// Compares every block with its checksum. Uses threads of its own while it runs.
void checkBlocks(ByteSpan file, const SectionRange& checksums, unsigned threads, Faults& faults);

}  // namespace foreland::terrain
