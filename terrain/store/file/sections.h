// What the files of terrains and of surfaces have in common: a page of header that begins with the same fields,
// page-aligned sections, and at the end a checksum for each block of the bytes between. docs/SCENE_FORMAT.md describes
// it for readers of other languages. Pure; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

#include "base/bytes.h"

namespace foreland::terrain {

inline constexpr uint32_t kByteOrderMark = 0x01020304;
inline constexpr uint64_t kPageBytes = 4096;       // alignment of every section
inline constexpr uint64_t kBlockBytes = 1u << 20;  // checksummed at a time
inline constexpr uint64_t kMaxTextBytes = 1u << 24;

struct SectionRange {
  uint64_t offset = 0;  // from the start of the file, a multiple of kPageBytes
  uint64_t bytes = 0;
  bool operator==(const SectionRange&) const = default;
};

// Blocks cover everything between the header page and the checksum table; the last may be short.
inline uint64_t blockCount(const SectionRange& checksums) {
  return (checksums.offset - kPageBytes + kBlockBytes - 1) / kBlockBytes;
}
ByteSpan blockAt(ByteSpan file, const SectionRange& checksums, uint64_t index);

// Lays out sections of the given sizes one after the other, then the checksum table, which becomes the last of
// `ranges`. Returns the size of the file.
uint64_t layOutSections(std::span<const uint64_t> bytes, std::span<SectionRange> ranges);

// XXH64 of the header page: the header, then zeros.
uint64_t pageHash(ByteSpan header, uint64_t seed = 0);

template <class Header>
uint64_t headerChecksum(Header header) {
  static_assert(std::is_trivially_copyable_v<Header> && sizeof(Header) <= kPageBytes);
  header.header_checksum = 0;
  return pageHash({reinterpret_cast<const uint8_t*>(&header), sizeof(header)});
}

uint64_t contentId(uint64_t page_hash, ByteSpan checksum_table);
// The id of a file's content: a hash of the header without its id and checksum, and of the checksum table.
template <class Header>
uint64_t contentId(Header header, ByteSpan checksum_table) {
  header.scene_id = 0;
  return contentId(headerChecksum(header), checksum_table);
}

}  // namespace foreland::terrain
