// The last step of writing: the checksums of the blocks, the id, the header, and the file gets its name.
#pragma once

#include <cstring>

#include "base/result.h"
#include "terrain/store/new_file.h"
#include "terrain/store/sections.h"

namespace foreland::terrain {

// Fills the checksum table; what has been summed may leave memory.
void sumBlocks(const NewFile& file, const SectionPlace& checksums);

// `header` is complete but for its id and checksum. Returns the id.
template <class Header>
Result<uint64_t> sealFile(NewFile& file, const SectionPlace& checksums, Header header) {
  sumBlocks(file, checksums);
  header.scene_id = contentId(header, file.span().subspan(checksums.offset, checksums.bytes));
  header.header_checksum = headerChecksum(header);
  std::memcpy(file.data(), &header, sizeof(header));
  if (Status status = file.finish(); !status.ok()) return status.error();
  return header.scene_id;
}

}  // namespace foreland::terrain
