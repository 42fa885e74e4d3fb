// The data behind a PLY file's header as a row of numbers, in whichever form. Past the end, or at a word that is no
// number, ok() turns false for good and values are 0. One owner.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <string_view>

#include "base/bytes.h"
#include "terrain/model/ply_header.h"
#include "terrain/model/words.h"

namespace foreland::terrain {

class PlyNumbers {
 public:
  PlyNumbers(ByteSpan bytes, PlyForm form)
      : bytes_(bytes),
        text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
        is_ascii_(form == PlyForm::kAscii),
        swaps_(form == PlyForm::kBigEndian) {}

  bool ok() const { return ok_; }
  // An element with this many numbers cannot take fewer bytes.
  uint64_t remainingBytes() const { return is_ascii_ ? text_.size() : bytes_.size(); }
  // 0 if only padding remains.
  uint64_t remainingContent() const {
    const auto isPadding = [](char c) {
      return c == 0 || c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == 0x1a;
    };
    const auto bytes =
        is_ascii_ ? text_ : std::string_view(reinterpret_cast<const char*>(bytes_.data()), bytes_.size());
    return std::all_of(bytes.begin(), bytes.end(), isPadding) ? 0 : bytes.size();
  }
  static uint64_t minBytes(PlyType type, PlyForm form) { return form == PlyForm::kAscii ? 2 : plyTypeBytes(type); }

  double next(PlyType type) { return is_ascii_ ? nextWord() : nextBinary(type); }

 private:
  double nextWord() {
    const size_t begin = std::min(text_.find_first_not_of(" \t\r\n"), text_.size());
    text_.remove_prefix(begin);
    const size_t end = std::min(text_.find_first_of(" \t\r\n"), text_.size());
    const auto value = parseNumber<double>(text_.substr(0, end));
    text_.remove_prefix(end);
    if (!value) ok_ = false;
    return value.value_or(0);
  }
  double nextBinary(PlyType type) {
    switch (type) {
      case PlyType::kInt8:
        return take<int8_t>();
      case PlyType::kUint8:
        return take<uint8_t>();
      case PlyType::kInt16:
        return take<int16_t>();
      case PlyType::kUint16:
        return take<uint16_t>();
      case PlyType::kInt32:
        return take<int32_t>();
      case PlyType::kUint32:
        return take<uint32_t>();
      case PlyType::kFloat:
        return take<float>();
      case PlyType::kDouble:
        return take<double>();
    }
    return 0;
  }
  template <class T>
  double take() {
    if (!ok_ || bytes_.size() < sizeof(T)) {
      ok_ = false;
      return 0;
    }
    std::array<uint8_t, sizeof(T)> raw;
    std::copy_n(bytes_.begin(), sizeof(T), raw.begin());
    if (swaps_) std::reverse(raw.begin(), raw.end());
    bytes_ = bytes_.subspan(sizeof(T));
    return static_cast<double>(std::bit_cast<T>(raw));
  }

  ByteSpan bytes_;
  std::string_view text_;
  bool is_ascii_, swaps_, ok_ = true;
};

}  // namespace foreland::terrain
