// Codes the pages of a terrain, for the scene's writer. Uses threads of its own while it runs.
#pragma once

#include <filesystem>
#include <span>

#include "base/bytes.h"
#include "base/result.h"
#include "terrain/store/coded/coded_pages.h"
#include "terrain/store/file/spool_file.h"

namespace foreland::terrain {

// The section of coded pages of a scene file that is to be at `target`. Memory: 8 bytes a group; the coded bytes wait
// in a file. The same bytes for any number of threads.
class CodedPagesWriter {
 public:
  static Result<CodedPagesWriter> create(const CodedTerrain& terrain, const std::filesystem::path& target,
                                         unsigned threads);

  uint64_t bytes() const { return CodedSection::tableBytes(ends_.size() - 1) + ends_.back(); }
  // Into bytes() bytes, which are zero.
  Status write(std::span<uint8_t> out) const;

 private:
  explicit CodedPagesWriter(SpoolFile spool) : spool_(std::move(spool)) {}
  Status append(ByteSpan bytes);

  std::vector<uint64_t> ends_;  // of the models' start, then of the groups
  SpoolFile spool_;
};

}  // namespace foreland::terrain
