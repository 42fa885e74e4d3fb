// The last step of writing a file: checksums of its blocks, its id and header, and its name.
#pragma once

#include <cstring>

#include "base/result.h"
#include "terrain/store/file/new_file.h"
#include "terrain/store/file/sections.h"

namespace foreland::terrain {

// Fills the checksum table and releases the blocks from memory.
void sumBlocks(const NewFile& file, const SectionRange& checksums);

// `header` must be complete except for its id and checksum. Returns the id.
template <class Header>
Result<uint64_t> sealFile(NewFile& file, const SectionRange& checksums, Header header) {
  sumBlocks(file, checksums);
  header.scene_id = contentId(header, file.span().subspan(checksums.offset, checksums.bytes));
  header.header_checksum = headerChecksum(header);
  std::memcpy(file.data(), &header, sizeof(header));
  if (Status status = file.finish(); !status.ok()) return status.error();
  return header.scene_id;
}

}  // namespace foreland::terrain
