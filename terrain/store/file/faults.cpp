#include "terrain/store/file/faults.h"

#include <sys/mman.h>

#include <algorithm>

#include "terrain/parallel.h"
#include "terrain/store/file/checksum.h"

namespace foreland::terrain {

namespace {

constexpr size_t kFaultsShown = 8;

}  // namespace

void Faults::add(uint64_t order, std::string what) {
  const std::lock_guard lock(mutex_);
  ++count_;
  if (first_.size() == kFaultsShown && first_.back().first <= order) return;
  first_.insert(std::upper_bound(first_.begin(), first_.end(), std::pair(order, what)), {order, what});
  if (first_.size() > kFaultsShown) first_.pop_back();
}

std::vector<std::string> Faults::first() const {
  std::vector<std::string> sentences;
  for (const auto& fault : first_) sentences.push_back(fault.second);
  return sentences;
}

void checkBlocks(ByteSpan file, const SectionRange& checksums, unsigned threads, Faults& faults) {
  const auto* expected = reinterpret_cast<const uint64_t*>(file.data() + checksums.offset);
  parallelFor(
      blockCount(checksums), threads,
      [&](uint64_t i, unsigned) {
        const ByteSpan block = blockAt(file, checksums, i);
        const bool intact = xxh64(block) == expected[i];
        // Blocks begin at pages. A scene may be larger than memory, so blocks that have been read are released.
        ::madvise(const_cast<uint8_t*>(block.data()), block.size(), MADV_DONTNEED);
        if (!intact)
          faults.add(i, "block " + std::to_string(i) + " (at byte " + std::to_string(kPageBytes + i * kBlockBytes) +
                            ") is damaged");
      },
      [](uint64_t) { return true; });
}

}  // namespace foreland::terrain
