// A file that is read at any offset, and not mapped: what is read may have any size, and an error is no signal. Any
// number of threads may read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <utility>

namespace foreland::terrain {

// Whether all of `out` could be read of an open file; errno says why not, unless the file ends before.
[[nodiscard]] bool readAt(int file, uint64_t offset, std::span<uint8_t> out);

class InputFile {
 public:
  InputFile() = default;
  // Not open if it cannot be; errno says why.
  explicit InputFile(const std::filesystem::path& path);
  InputFile(InputFile&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
  InputFile& operator=(InputFile&& other) noexcept {
    std::swap(file_, other.file_);
    return *this;
  }
  ~InputFile();

  bool isOpen() const { return file_ >= 0; }
  // Nothing if that cannot be found out.
  std::optional<uint64_t> bytes() const;
  [[nodiscard]] bool read(uint64_t offset, std::span<uint8_t> out) const { return readAt(file_, offset, out); }

 private:
  int file_ = -1;
};

}  // namespace foreland::terrain
