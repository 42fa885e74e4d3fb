#include "terrain/store/file/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace foreland::terrain {

bool readAt(int file, uint64_t offset, std::span<uint8_t> out) {
  for (size_t done = 0; done < out.size();) {
    const ssize_t got = ::pread(file, out.data() + done, out.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    done += static_cast<size_t>(got);
  }
  return true;
}

InputFile::InputFile(const std::filesystem::path& path) : file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {}

InputFile::~InputFile() {
  if (file_ >= 0) ::close(file_);
}

std::optional<uint64_t> InputFile::bytes() const {
  struct stat about {};
  return ::fstat(file_, &about) == 0 ? std::optional(static_cast<uint64_t>(about.st_size)) : std::nullopt;
}

}  // namespace foreland::terrain
