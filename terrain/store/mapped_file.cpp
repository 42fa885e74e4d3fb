#include "terrain/store/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace foreland::terrain {

namespace {

Error fromSystem(const std::filesystem::path& path) {
  const ErrorCode code = errno == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo;
  return {code, path.string() + ": " + std::strerror(errno) +
                    (code == ErrorCode::kNotFound ? "; `foreland build` makes a scene" : "")};
}

}  // namespace

Error damagedFile(const std::filesystem::path& path, const std::string& what) {
  return {ErrorCode::kMalformed, path.string() + ": " + what + "; build or copy the scene again"};
}

Result<MappedFile> MappedFile::open(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return fromSystem(path);
  struct stat about {};
  void* data = MAP_FAILED;
  Status status;
  if (::fstat(file, &about) != 0) {
    status = fromSystem(path);
  } else if (!S_ISREG(about.st_mode)) {
    status = Error{ErrorCode::kInvalidArgument, path.string() + ": not a file; name a scene made by `foreland build`"};
  } else if (static_cast<uint64_t>(about.st_size) < kPageBytes) {
    status = Error{ErrorCode::kMalformed, path.string() + ": not a scene (only " + std::to_string(about.st_size) +
                                              " bytes); name a file made by `foreland build`"};
  } else {
    data = ::mmap(nullptr, static_cast<size_t>(about.st_size), PROT_READ, MAP_SHARED, file, 0);
    if (data == MAP_FAILED) status = fromSystem(path);
  }
  ::close(file);
  if (!status.ok()) return status.error();
  return MappedFile(ByteSpan(static_cast<const uint8_t*>(data), static_cast<size_t>(about.st_size)));
}

MappedFile::MappedFile(MappedFile&& other) noexcept : data_(std::exchange(other.data_, {})) {}

MappedFile::~MappedFile() {
  if (!data_.empty()) ::munmap(const_cast<uint8_t*>(data_.data()), data_.size());
}

Status checkStart(ByteSpan file, const std::filesystem::path& path, const HeaderStart& wanted, size_t header_bytes,
                  uint64_t checksum) {
  HeaderStart start;
  std::memcpy(&start, file.data(), sizeof(start));
  if (start.magic != wanted.magic)
    return Error{ErrorCode::kMalformed, path.string() + ": not a scene; name a file made by `foreland build`"};
  if (start.byte_order != wanted.byte_order)
    return Error{ErrorCode::kUnsupported, path.string() + ": written with another byte order; build the scene again"};
  if (start.version != wanted.version)
    return Error{ErrorCode::kUnsupported, path.string() + ": scene format " + std::to_string(start.version) +
                                              ", this program reads " + std::to_string(wanted.version) +
                                              "; build the scene again"};
  const auto rest = file.subspan(header_bytes, kPageBytes - header_bytes);
  if (start.header_checksum != checksum ||
      std::any_of(rest.begin(), rest.end(), [](uint8_t byte) { return byte != 0; }))
    return damagedFile(path, "its header is damaged");
  if (start.file_bytes != file.size())
    return damagedFile(
        path, "it should have " + std::to_string(start.file_bytes) + " bytes but has " + std::to_string(file.size()));
  return {};
}

}  // namespace foreland::terrain
