// A file under a temporary name beside its destination: commit() moves it there, anything else removes it. One owner.
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
  // Call when everything is written and closed: to the disk, then to its name.
  Status commit();

 private:
  std::filesystem::path destination_, temporary_;
};

}  // namespace foreland::terrain
