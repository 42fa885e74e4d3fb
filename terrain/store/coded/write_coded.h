// Codes the pages of a terrain, for the scene's writer. Uses threads of its own while it runs.
#pragma once

#include <filesystem>
#include <functional>
#include <span>

#include "base/bytes.h"
#include "base/result.h"
#include "terrain/store/coded/coded_pages.h"
#include "terrain/store/file/spool_file.h"

namespace foreland::terrain {

// The section of coded pages of a scene file that is to be at `target`. Memory: 8 bytes a group, and for each thread
// that of a GroupReader; the coded bytes wait in a file. The same bytes for any number of threads.
class CodedPagesWriter {
 public:
  // `read` is called by several threads at once. terrain.records are not looked at.
  static Result<CodedPagesWriter> create(const CodedTerrain& terrain, const GroupReader::Read& read,
                                         const std::filesystem::path& target, unsigned threads);

  uint64_t bytes() const { return CodedSection::tableBytes(ends_.size() - 1) + ends_.back(); }
  // Calls put(offset, bytes) for all of its bytes(), in pieces.
  Status write(const std::function<Status(uint64_t offset, ByteSpan what)>& put) const;

 private:
  explicit CodedPagesWriter(SpoolFile spool) : spool_(std::move(spool)) {}
  Status append(ByteSpan bytes);

  std::vector<uint64_t> ends_;  // of the models' start, then of the groups
  SpoolFile spool_;
};

}  // namespace foreland::terrain
