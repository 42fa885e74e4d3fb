#include "terrain/store/file/spool_file.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <utility>

#include "terrain/store/file/input_file.h"

namespace foreland::terrain {

Error SpoolFile::systemError(const char* doing) const {
  const std::string why = std::strerror(errno);
  const std::string way_out = errno == ENOSPC || errno == EFBIG || errno == EDQUOT
                                  ? "; make room there, " + std::to_string((end_ >> 20) + 1) + " MiB are not enough"
                                  : "";
  return {ErrorCode::kIo, target_.string() + ": " + doing + " a temporary file beside it: " + why + way_out};
}

int openUnnamed(const std::filesystem::path& folder) {
  int file = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file < 0 && (errno == EOPNOTSUPP || errno == EISDIR || errno == EINVAL)) {
    std::string name = (folder / ".foreland-XXXXXX").string();
    file = ::mkostemp(name.data(), O_CLOEXEC);
    if (file >= 0) ::unlink(name.c_str());
  }
  return file;
}

Result<SpoolFile> SpoolFile::create(const std::filesystem::path& target) {
  SpoolFile spool(target);
  spool.file_ = openUnnamed(target.has_parent_path() ? target.parent_path() : std::filesystem::path("."));
  if (spool.file_ < 0) return spool.systemError("cannot create");
  return spool;
}

SpoolFile::SpoolFile(SpoolFile&& other) noexcept
    : target_(std::move(other.target_)), file_(std::exchange(other.file_, -1)), end_(other.end_.load()) {}

SpoolFile::~SpoolFile() {
  if (file_ >= 0) ::close(file_);
}

Result<uint64_t> SpoolFile::append(ByteSpan what) {
  const uint64_t offset = end_.fetch_add(what.size());
  if (Status s = put(offset, what); !s.ok()) return s.error();
  return offset;
}

Status SpoolFile::put(uint64_t offset, ByteSpan what) {
  const uint64_t end = offset + what.size();
  for (uint64_t before = end_; before < end && !end_.compare_exchange_weak(before, end);) {}
  // Writing beyond a file size limit would raise a signal instead of returning an error.
  rlimit limit{};
  if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY && end > limit.rlim_cur) {
    errno = EFBIG;
    return systemError("cannot write");
  }
  for (size_t done = 0; done < what.size();) {
    const ssize_t n = ::pwrite(file_, what.data() + done, what.size() - done, static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return systemError("cannot write");
    done += static_cast<size_t>(n);
  }
  return {};
}

Status SpoolFile::read(uint64_t offset, std::span<uint8_t> out) const {
  return readAt(file_, offset, out) ? Status() : Status(systemError("cannot read"));
}

}  // namespace foreland::terrain
