// The last step of writing a file: checksums of its blocks, its id and header, and its name.
#pragma once

#include "base/bytes.h"
#include "base/result.h"
#include "terrain/store/file/new_file.h"
#include "terrain/store/file/sections.h"

namespace foreland::terrain {

// Writes the checksum table, releases the blocks from memory and returns the table.
Result<Bytes> sumBlocks(const NewFile& file, const SectionRange& checksums);

// `header` must be complete except for its id and checksum. Returns the id.
template <class Header>
Result<uint64_t> sealFile(NewFile& file, const SectionRange& checksums, Header header) {
  const auto table = sumBlocks(file, checksums);
  if (!table) return table.error();
  header.scene_id = contentId(header, *table);
  header.header_checksum = headerChecksum(header);
  const ByteSpan page{reinterpret_cast<const uint8_t*>(&header), sizeof(header)};
  if (Status status = file.put(0, page); !status.ok()) return status.error();
  if (Status status = file.finish(); !status.ok()) return status.error();
  return header.scene_id;
}

}  // namespace foreland::terrain
