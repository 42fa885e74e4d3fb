// A file under a temporary name beside its destination: commit() renames it, the destructor removes it otherwise. One
// owner.
#pragma once

#include <filesystem>

#include "base/result.h"

namespace foreland::terrain {

class PendingFile {
 public:
  explicit PendingFile(const std::filesystem::path& destination);
  ~PendingFile();
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;

  const std::filesystem::path& path() const { return temporary_; }
  const std::filesystem::path& destination() const { return destination_; }
  // Flushes the file to the disk and renames it. Call once everything is written and closed.
  Status commit();

 private:
  std::filesystem::path destination_, temporary_;
};

}  // namespace foreland::terrain
