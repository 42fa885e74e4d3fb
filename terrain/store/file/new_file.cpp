#include "terrain/store/file/new_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "terrain/store/file/input_file.h"

namespace foreland::terrain {

namespace {

constexpr uintptr_t kPage = 4096;

std::filesystem::path folderOf(const std::filesystem::path& target) {
  return target.has_parent_path() ? target.parent_path() : std::filesystem::path(".");
}

// A hidden name beside the target that no other process uses.
std::filesystem::path hiddenName(const std::filesystem::path& target) {
  static std::atomic<uint32_t> counter{0};
  std::string name(".");  // appended to: g++ 12 warns falsely of operator+ here
  name += target.filename().string();
  name += '.' + std::to_string(::getpid()) + '-' + std::to_string(counter++) + ".part";
  return folderOf(target) / name;
}

Status checkTarget(const std::filesystem::path& target) {
  struct stat about {};
  if (target.filename().empty() || (::stat(target.c_str(), &about) == 0 && !S_ISREG(about.st_mode)))
    return Error{ErrorCode::kInvalidArgument,
                 target.string() + ": not a file that can be written; name a file to create"};
  return {};
}

}  // namespace

Error NewFile::systemError(const std::string& doing) const {
  const std::string why = std::strerror(errno);
  const std::string way_out = errno == ENOSPC || errno == EFBIG || errno == EDQUOT
                                  ? "; the file needs " + std::to_string((bytes_ >> 20) + 1) + " MiB"
                                  : "";
  return {ErrorCode::kIo, target_.string() + ": " + doing + ": " + why + way_out};
}

Result<NewFile> NewFile::create(const std::filesystem::path& target, uint64_t bytes, FileMapping mapping) {
  NewFile file;
  file.target_ = target;
  file.bytes_ = bytes;
  if (Status status = checkTarget(target); !status.ok()) return status.error();
  if (Status status = file.openTemporary(); !status.ok()) return status.error();
  if (Status status = file.reserve(mapping); !status.ok()) return status.error();
  return file;
}

NewFile::NewFile(NewFile&& other) noexcept
    : target_(std::move(other.target_)),
      temporary_(std::exchange(other.temporary_, {})),
      file_(std::exchange(other.file_, -1)),
      data_(std::exchange(other.data_, nullptr)),
      bytes_(other.bytes_) {}

NewFile::~NewFile() {
  if (data_) ::munmap(data_, bytes_);
  if (file_ >= 0) ::close(file_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

Status NewFile::openTemporary() {
  constexpr int kMode = 0666;  // as the umask allows
  file_ = ::open(folderOf(target_).c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, kMode);
  if (file_ >= 0) return {};
  if (errno != EOPNOTSUPP && errno != EISDIR && errno != EINVAL) return systemError("cannot create it");
  const auto hidden = hiddenName(target_);
  file_ = ::open(hidden.c_str(), O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, kMode);
  if (file_ < 0) return systemError("cannot create it");
  temporary_ = hidden;
  return {};
}

Status NewFile::reserve(FileMapping mapping) {
  // Writing beyond a file size limit would raise a signal instead of returning an error.
  rlimit limit{};
  if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY && bytes_ > limit.rlim_cur) {
    errno = EFBIG;
    return systemError("cannot reserve its space");
  }
  if (const int error = ::posix_fallocate(file_, 0, static_cast<off_t>(bytes_)); error != 0) {
    errno = error;
    return systemError("cannot reserve its space");
  }
  if (mapping == FileMapping::kNone) return {};
  void* data = ::mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_SHARED, file_, 0);
  if (data == MAP_FAILED) return systemError("cannot map it");
  data_ = static_cast<uint8_t*>(data);
  return {};
}

Status NewFile::put(uint64_t offset, ByteSpan what) const {
  for (size_t done = 0; done < what.size();) {
    const ssize_t written = ::pwrite(file_, what.data() + done, what.size() - done, static_cast<off_t>(offset + done));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return systemError("cannot write it");
    done += static_cast<size_t>(written);
  }
  return {};
}

Status NewFile::read(uint64_t offset, std::span<uint8_t> out) const {
  return readAt(file_, offset, out) ? Status() : Status(systemError("cannot read it again"));
}

void NewFile::release(ByteSpan what) const {
  const auto begin = (reinterpret_cast<uintptr_t>(what.data()) + kPage - 1) & ~(kPage - 1);
  const auto end = reinterpret_cast<uintptr_t>(what.data() + what.size()) & ~(kPage - 1);
  if (begin < end) ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_DONTNEED);
}

Status NewFile::finish() {
  if ((data_ && ::msync(data_, bytes_, MS_SYNC) != 0) || ::fsync(file_) != 0) return systemError("cannot write it");
  return name();
}

// linkat() cannot replace a file, so an unnamed file is linked to the hidden name first and then renamed.
Status NewFile::name() {
  if (temporary_.empty()) {
    const auto hidden = hiddenName(target_);
    const std::string unnamed = "/proc/self/fd/" + std::to_string(file_);
    if (::linkat(AT_FDCWD, unnamed.c_str(), AT_FDCWD, hidden.c_str(), AT_SYMLINK_FOLLOW) != 0)
      return systemError("cannot name it");
    temporary_ = hidden;
  }
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) return systemError("cannot name it");
  temporary_.clear();
  if (const int folder = ::open(folderOf(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); folder >= 0) {
    ::fsync(folder);  // best effort: the file itself is safe already
    ::close(folder);
  }
  return {};
}

}  // namespace foreland::terrain
