// A file that appears whole or not at all: it has no name until it is complete and on the disk (O_TMPFILE; on file
// systems without unnamed files, a hidden temporary name that is removed on failure), then it replaces the target in
// one rename. Space is reserved before anything is written, so a full disk is an Error and never a signal.
//
// One owner; put() may be called by several threads at once.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "base/bytes.h"
#include "base/result.h"

namespace foreland::terrain {

// Whether a new file is mapped into memory: without it a process of little address space can write it.
enum class FileMapping : uint8_t { kMapped, kNone };

class NewFile {
 public:
  // `bytes` are reserved, zero and, unless `mapping` says otherwise, mapped.
  static Result<NewFile> create(const std::filesystem::path& target, uint64_t bytes,
                                FileMapping mapping = FileMapping::kMapped);

  NewFile(NewFile&& other) noexcept;
  NewFile& operator=(NewFile&&) = delete;
  ~NewFile();

  uint8_t* data() const { return data_; }  // null if it is not mapped
  uint64_t bytes() const { return bytes_; }
  ByteSpan span() const { return {data_, bytes_}; }

  // Writes at `offset`; data() shows the result. A write call costs a third of stores through the mapping.
  Status put(uint64_t offset, ByteSpan what) const;
  // Fills `out` with what was written from `offset` on.
  Status read(uint64_t offset, std::span<uint8_t> out) const;
  // Lets pages of data() leave this process's memory; their content stays in the file.
  void release(ByteSpan what) const;

  // Flushes the file to the disk and gives it its name. Call once, when everything is filled.
  Status finish();

 private:
  NewFile() = default;
  Status openTemporary();
  Status reserve(FileMapping mapping);
  Status name();
  Error systemError(const std::string& doing) const;

  std::filesystem::path target_, temporary_;  // temporary_ is empty while the file has no name
  int file_ = -1;
  uint8_t* data_ = nullptr;
  uint64_t bytes_ = 0;
};

}  // namespace foreland::terrain
