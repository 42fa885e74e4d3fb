#include "terrain/store/file/sections.h"

#include <algorithm>

#include "base/check.h"
#include "terrain/store/file/checksum.h"

namespace foreland::terrain {

ByteSpan blockAt(ByteSpan file, const SectionRange& checksums, uint64_t index) {
  const uint64_t begin = kPageBytes + index * kBlockBytes;
  return file.subspan(begin, std::min(kBlockBytes, checksums.offset - begin));
}

uint64_t layOutSections(std::span<const uint64_t> bytes, std::span<SectionRange> ranges) {
  CHECK_EQ(ranges.size(), bytes.size() + 1);
  uint64_t at = kPageBytes;
  for (size_t i = 0; i < bytes.size(); ++i) {
    ranges[i] = {at, bytes[i]};
    at = (at + bytes[i] + kPageBytes - 1) / kPageBytes * kPageBytes;
  }
  SectionRange& checksums = ranges.back();
  checksums.offset = at;
  checksums.bytes = sizeof(uint64_t) * blockCount(checksums);
  return at + checksums.bytes;
}

uint64_t pageHash(ByteSpan header, uint64_t seed) {
  std::array<uint8_t, kPageBytes> page{};
  std::copy(header.begin(), header.end(), page.begin());
  return xxh64(page, seed);
}

uint64_t contentId(uint64_t page_hash, ByteSpan checksum_table) { return xxh64(checksum_table, page_hash); }

}  // namespace foreland::terrain
