// The fields of a request that say which form of a file is wanted: RFC 9110. Pure; any thread.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace foreland::server {

// Without white space at either end.
std::string_view trimmed(std::string_view text);

bool equalsIgnoringCase(std::string_view a, std::string_view b);

// Whether an If-None-Match field names the entity tag: in a list, weak or not, or by `*`.
bool namesTag(std::string_view if_none_match, std::string_view etag);

// Whether an Accept-Encoding field takes the coding. What is not named is not taken.
bool acceptsCoding(std::string_view accept_encoding, std::string_view coding);

// The bytes from `begin` up to `end`, which is one past the last.
struct ByteRange {
  size_t begin = 0, end = 0;
  bool operator==(const ByteRange&) const = default;
};
enum class RangeKind { kNone, kSome, kUnsatisfiable };
struct RequestedRange {
  RangeKind kind = RangeKind::kNone;
  ByteRange range{};
};

// What a Range field asks for of `size` bytes. kNone, the whole, if there is no field, or one that is malformed, of
// another unit or of several ranges, as a server may choose.
RequestedRange rangeOf(std::string_view range, size_t size);

}  // namespace foreland::server
