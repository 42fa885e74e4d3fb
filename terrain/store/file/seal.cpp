#include "terrain/store/file/seal.h"

#include "terrain/store/file/checksum.h"

namespace foreland::terrain {

void sumBlocks(const NewFile& file, const SectionRange& checksums) {
  auto* table = reinterpret_cast<uint64_t*>(file.data() + checksums.offset);
  for (uint64_t i = 0; i < blockCount(checksums); ++i) {
    const ByteSpan block = blockAt(file.span(), checksums, i);
    table[i] = xxh64(block);
    file.release(block);
  }
}

}  // namespace foreland::terrain
