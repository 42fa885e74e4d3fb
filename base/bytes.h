// Bounds-checked reading and writing of bytes, little-endian, with LEB128 varints. Readers accept any bytes: a read
// past the end yields zero and makes `ok()` false for good, so a decoder may check once after a group of reads. Value
// types, one owner; portable to WebAssembly.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

#include "base/zigzag.h"

namespace foreland {

static_assert(std::endian::native == std::endian::little, "wire and file are little-endian");

using Bytes = std::vector<uint8_t>;
using ByteSpan = std::span<const uint8_t>;

class ByteWriter {
 public:
  explicit ByteWriter(Bytes& out) : out_(out) {}

  template <class T>
  requires std::is_trivially_copyable_v<T>
  void put(const T& value) {
    const size_t at = out_.size();
    out_.resize(at + sizeof(T));
    std::memcpy(out_.data() + at, &value, sizeof(T));
  }
  void putBytes(ByteSpan bytes) { out_.insert(out_.end(), bytes.begin(), bytes.end()); }
  void putVarint(uint64_t value) {
    while (value >= 0x80) {
      out_.push_back(static_cast<uint8_t>(value | 0x80));
      value >>= 7;
    }
    out_.push_back(static_cast<uint8_t>(value));
  }
  void putZigzag(int64_t value) { putVarint(toZigzag(value)); }

 private:
  Bytes& out_;
};

class ByteReader {
 public:
  explicit ByteReader(ByteSpan bytes) : bytes_(bytes) {}

  bool ok() const { return ok_; }
  size_t remaining() const { return bytes_.size() - at_; }
  bool atEnd() const { return ok_ && remaining() == 0; }

  template <class T>
  requires std::is_trivially_copyable_v<T> T get() {
    T value{};
    if (!take(sizeof(T))) return value;
    std::memcpy(&value, bytes_.data() + at_ - sizeof(T), sizeof(T));
    return value;
  }
  ByteSpan getBytes(size_t count) { return take(count) ? bytes_.subspan(at_ - count, count) : ByteSpan{}; }
  // Reads at most ten bytes; a longer or overflowing encoding makes `ok()` false.
  uint64_t getVarint() {
    uint64_t value = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      const uint8_t byte = get<uint8_t>();
      if (shift == 63 && byte > 1) ok_ = false;
      if (!ok_) return 0;
      value |= static_cast<uint64_t>(byte & 0x7f) << shift;
      if (byte < 0x80) return value;
    }
    ok_ = false;
    return 0;
  }
  int64_t getZigzag() { return fromZigzag(getVarint()); }

 private:
  bool take(size_t count) {
    if (!ok_ || count > remaining()) {
      ok_ = false;
      return false;
    }
    at_ += count;
    return true;
  }

  ByteSpan bytes_;
  size_t at_ = 0;
  bool ok_ = true;
};

}  // namespace foreland
