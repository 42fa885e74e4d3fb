// A whole file mapped into memory for reading. Immutable; any thread. The file must not be changed in place while it is
// open; our writer never does (it replaces it by rename). If someone else cuts it short, or its disk fails, reading it
// raises SIGBUS; endWhenAFileIsLost() makes of that a message and a clean end (docs/decisions/0019).
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include "base/bytes.h"
#include "base/result.h"
#include "terrain/store/file/sections.h"

namespace foreland::terrain {

// A section of a mapped file as records. Sections begin at pages, so records are aligned.
template <class T>
std::span<const T> sectionOf(ByteSpan file, const SectionRange& range) {
  return {reinterpret_cast<const T*>(file.data() + range.offset), range.bytes / sizeof(T)};
}

class MappedFile {
 public:
  // A regular file of at least a page.
  static Result<MappedFile> open(const std::filesystem::path& path);

  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&&) = delete;
  ~MappedFile();

  ByteSpan span() const { return data_; }

 private:
  MappedFile(ByteSpan data, const std::filesystem::path& path);

  ByteSpan data_;  // owned
};

// From now on, when a mapped file cannot be read any more, the program names the file on standard error and ends with
// this exit code, instead of dying of SIGBUS. For mains; other causes of SIGBUS stay what they are.
inline constexpr int kFileLost = 3;
void endWhenAFileIsLost();

// The fields that every kind of header begins with.
struct HeaderStart {
  std::array<char, 8> magic{};
  uint32_t version = 0;
  uint32_t byte_order = 0;
  uint64_t file_bytes = 0;
  uint64_t scene_id = 0;
  uint64_t header_checksum = 0;
};
static_assert(sizeof(HeaderStart) == 40);

// Checks that the file has the magic of `wanted` and a version from `oldest_version` to that of `wanted`, an undamaged
// header (`checksum` is what its checksum must be) and the size that the header states. Errors name the path and the
// remedy.
Status checkStart(ByteSpan file, const std::filesystem::path& path, const HeaderStart& wanted, uint32_t oldest_version,
                  size_t header_bytes, uint64_t checksum);

template <class Header>
Result<Header> readHeader(ByteSpan file, const std::filesystem::path& path) {
  Header header;
  const Header fresh;
  HeaderStart wanted;
  std::memcpy(&header, file.data(), sizeof(header));
  std::memcpy(&wanted, reinterpret_cast<const uint8_t*>(&fresh), sizeof(wanted));
  uint32_t oldest_version = wanted.version;
  if constexpr (requires { Header::kOldestVersion; }) oldest_version = Header::kOldestVersion;
  if (Status status = checkStart(file, path, wanted, oldest_version, sizeof(header), headerChecksum(header));
      !status.ok())
    return status.error();
  return header;
}

// Maps a whole file and opens its bytes with `T::of`, which keeps the mapping alive.
template <class T, class... More>
Result<std::shared_ptr<const T>> openMapped(const std::filesystem::path& path, const More&... more) {
  auto file = MappedFile::open(path);
  if (!file.ok()) return file.error();
  auto owner = std::make_shared<const MappedFile>(std::move(file).value());
  const ByteSpan bytes = owner->span();
  return T::of(bytes, path.string(), std::move(owner), more...);
}

Error damagedFile(const std::filesystem::path& path, const std::string& what);

}  // namespace foreland::terrain
