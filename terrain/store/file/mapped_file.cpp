#include "terrain/store/file/mapped_file.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <mutex>
#include <string>
#include <utility>

#include "base/printable.h"

namespace foreland::terrain {

namespace {

// The mapped files, for a signal handler: fixed memory, and atomic numbers that it may read at any time.
struct MappingName {
  std::atomic<uintptr_t> begin{0}, end{0};  // begin 0: free
  char path[1024] = {};
};
std::array<MappingName, 64> mapping_names;
std::mutex mapping_names_mutex;  // of those who write

void remember(ByteSpan data, const std::filesystem::path& path) {
  const std::lock_guard lock(mapping_names_mutex);
  for (MappingName& name : mapping_names) {
    if (name.begin != 0) continue;
    const std::string text = printable(path.string(), sizeof(name.path) - 4);
    std::memcpy(name.path, text.c_str(), text.size() + 1);
    name.end = reinterpret_cast<uintptr_t>(data.data()) + data.size();
    name.begin = reinterpret_cast<uintptr_t>(data.data());
    return;
  }
}

void forget(ByteSpan data) {
  const std::lock_guard lock(mapping_names_mutex);
  for (MappingName& name : mapping_names)
    if (name.begin == reinterpret_cast<uintptr_t>(data.data())) name.begin = 0;
}

// Calls nothing that a signal handler may not call.
void onBusError(int, siginfo_t* about, void*) {
  const auto at = reinterpret_cast<uintptr_t>(about->si_addr);
  const auto tell = [](const char* text) {
    [[maybe_unused]] const auto n = ::write(STDERR_FILENO, text, std::strlen(text));
  };
  for (const MappingName& name : mapping_names) {
    if (name.begin == 0 || at < name.begin || at >= name.end) continue;
    tell("foreland: ");
    tell(name.path);
    tell(
        ": cannot be read any more. The file was cut short, or its disk failed, while it was open; restore it and "
        "start again\n");
    ::_exit(kFileLost);
  }
  ::signal(SIGBUS, SIG_DFL);
  ::raise(SIGBUS);
}

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
  return MappedFile(ByteSpan(static_cast<const uint8_t*>(data), static_cast<size_t>(about.st_size)), path);
}

MappedFile::MappedFile(ByteSpan data, const std::filesystem::path& path) : data_(data) { remember(data_, path); }

void endWhenAFileIsLost() {
  struct sigaction action {};
  action.sa_sigaction = onBusError;
  action.sa_flags = SA_SIGINFO;
  ::sigaction(SIGBUS, &action, nullptr);
}

MappedFile::MappedFile(MappedFile&& other) noexcept : data_(std::exchange(other.data_, {})) {}

MappedFile::~MappedFile() {
  if (data_.empty()) return;
  forget(data_);
  ::munmap(const_cast<uint8_t*>(data_.data()), data_.size());
}

Status checkStart(ByteSpan file, const std::filesystem::path& path, const HeaderStart& wanted, uint32_t oldest_version,
                  size_t header_bytes, uint64_t checksum) {
  HeaderStart start;
  std::memcpy(&start, file.data(), sizeof(start));
  if (start.magic != wanted.magic)
    return Error{ErrorCode::kMalformed, path.string() + ": not a scene; name a file made by `foreland build`"};
  if (start.byte_order != wanted.byte_order)
    return Error{ErrorCode::kUnsupported, path.string() + ": written with another byte order; build the scene again"};
  if (start.version < oldest_version || start.version > wanted.version)
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
