#include "terrain/model/gltf/uri.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>

namespace foreland::terrain {

namespace {

// The name as it may stand in a message.
std::string shown(std::string_view uri) { return "'" + std::string(uri.substr(0, 80)) + "'"; }

std::optional<uint32_t> sextet(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+' || c == '-') return 62;
  if (c == '/' || c == '_') return 63;
  return std::nullopt;
}

Result<Bytes> decodeBase64(std::string_view text) {
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  Bytes bytes;
  bytes.reserve(text.size() / 4 * 3 + 2);
  uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    const auto value = sextet(c);
    if (!value) return Error{ErrorCode::kMalformed, "has a data URI that is no base64; export the model again"};
    bits = bits << 6 | *value;
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<uint8_t>(bits >> count));
  }
  return bytes;
}

// "%20" and its like stand for bytes.
std::string percentDecoded(std::string_view uri) {
  std::string text;
  for (size_t i = 0; i < uri.size(); ++i) {
    unsigned byte = 0;
    const bool is_coded = uri[i] == '%' && i + 2 < uri.size() &&
                          std::from_chars(uri.data() + i + 1, uri.data() + i + 3, byte, 16).ptr == uri.data() + i + 3;
    text += is_coded ? static_cast<char>(byte) : uri[i];
    if (is_coded) i += 2;
  }
  return text;
}

}  // namespace

bool isDataUri(std::string_view uri) { return uri.starts_with("data:"); }

Result<Bytes> decodeDataUri(std::string_view uri) {
  const size_t comma = uri.find(',');
  if (comma == std::string_view::npos || !uri.substr(0, comma).ends_with(";base64"))
    return Error{ErrorCode::kUnsupported, "has a data URI that is not in base64; export the model again"};
  return decodeBase64(uri.substr(comma + 1));
}

Result<std::string> fileOfUri(std::string_view uri) {
  std::string text = percentDecoded(uri);
  std::replace(text.begin(), text.end(), '\\', '/');
  if (text.empty() || text.find('\0') != std::string::npos)
    return Error{ErrorCode::kMalformed, "names the file " + shown(uri) + ", which is no name; export the model again"};
  return std::filesystem::path(text).lexically_normal().string();
}

}  // namespace foreland::terrain
