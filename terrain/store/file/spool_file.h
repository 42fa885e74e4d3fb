// A file without a name that grows while something is made whose size is not known before; it is gone when its owner
// is. Threads: append(), put() and read() may be called by several at once.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <span>

#include "base/bytes.h"
#include "base/result.h"

namespace foreland::terrain {

// Opens a file without a name in a folder, for reading and writing; below 0, with errno, if it cannot.
int openUnnamed(const std::filesystem::path& folder);

class SpoolFile {
 public:
  // On the disk that `target` will be on.
  static Result<SpoolFile> create(const std::filesystem::path& target);

  SpoolFile(SpoolFile&& other) noexcept;
  SpoolFile& operator=(SpoolFile&&) = delete;
  ~SpoolFile();

  // Returns the offset that read() takes.
  Result<uint64_t> append(ByteSpan what);
  // Writes at an offset of the caller's choice, also over what is there.
  Status put(uint64_t offset, ByteSpan what);
  // Fills `out`, all of which must have been written.
  Status read(uint64_t offset, std::span<uint8_t> out) const;
  uint64_t bytes() const { return end_; }

 private:
  explicit SpoolFile(const std::filesystem::path& target) : target_(target) {}
  Error systemError(const char* doing) const;

  std::filesystem::path target_;
  int file_ = -1;
  std::atomic<uint64_t> end_{0};
};

}  // namespace foreland::terrain
