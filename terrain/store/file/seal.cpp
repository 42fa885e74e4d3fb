#include "terrain/store/file/seal.h"

#include <algorithm>
#include <cstring>

#include "terrain/store/file/checksum.h"

namespace foreland::terrain {

Result<Bytes> sumBlocks(const NewFile& file, const SectionRange& checksums) {
  Bytes table(checksums.bytes), scratch;
  for (uint64_t i = 0; i < blockCount(checksums); ++i) {
    ByteSpan block;
    if (file.data()) {
      block = blockAt(file.span(), checksums, i);
    } else {
      const uint64_t offset = kPageBytes + i * kBlockBytes;
      scratch.resize(std::min(kBlockBytes, checksums.offset - offset));
      if (Status s = file.read(offset, scratch); !s.ok()) return s.error();
      block = scratch;
    }
    const uint64_t sum = xxh64(block);
    std::memcpy(table.data() + i * sizeof(sum), &sum, sizeof(sum));
    if (file.data()) file.release(block);
  }
  if (Status s = file.put(checksums.offset, table); !s.ok()) return s.error();
  return table;
}

}  // namespace foreland::terrain
