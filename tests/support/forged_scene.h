// Scene files whose content was changed and whose checksums were made to agree again: only the invariants can tell.
#pragma once

#include <cstring>
#include <vector>

#include "terrain/store/file/checksum.h"
#include "terrain/store/format.h"

namespace foreland::test {

// Makes checksums, id and header of a scene file agree with its content and with `header`.
inline void sealScene(std::vector<char>& bytes, terrain::FileHeader header) {
  const ByteSpan file(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
  const terrain::SectionRange& table = header.sections[terrain::kChecksums];
  for (uint64_t i = 0; i < terrain::blockCount(table); ++i) {
    const uint64_t sum = terrain::xxh64(terrain::blockAt(file, table, i));
    std::memcpy(bytes.data() + table.offset + i * sizeof(sum), &sum, sizeof(sum));
  }
  header.scene_id = terrain::contentId(header, file.subspan(table.offset, table.bytes));
  header.header_checksum = terrain::headerChecksum(header);
  std::memcpy(bytes.data(), &header, sizeof(header));
}

inline terrain::FileHeader headerOf(const std::vector<char>& bytes) {
  terrain::FileHeader header;
  std::memcpy(&header, bytes.data(), sizeof(header));
  return header;
}

}  // namespace foreland::test
