#include "terrain/dem/formats/pending_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

namespace foreland::terrain {

PendingFile::PendingFile(const std::filesystem::path& destination)
    : destination_(destination),
      temporary_(destination.parent_path() / ("." + destination.stem().string() + "." + std::to_string(getpid()) +
                                              ".part" + destination.extension().string())) {}

PendingFile::~PendingFile() {
  std::error_code ignored;
  if (!temporary_.empty()) std::filesystem::remove(temporary_, ignored);
}

Status PendingFile::commit() {
  const int file = open(temporary_.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = file >= 0 && fsync(file) == 0;
  std::error_code failed(synced ? 0 : errno, std::generic_category());
  if (file >= 0) close(file);
  if (synced) std::filesystem::rename(temporary_, destination_, failed);
  if (failed) return Error{ErrorCode::kIo, destination_.string() + ": cannot be written: " + failed.message()};
  temporary_.clear();
  return {};
}

}  // namespace foreland::terrain
