#include "server/net/http/http_fields.h"

#include <algorithm>
#include <boost/beast/http/rfc7230.hpp>
#include <charconv>

namespace foreland::server {

std::string_view trimmed(std::string_view text) {
  const size_t begin = text.find_first_not_of(" \t"), end = text.find_last_not_of(" \t");
  return begin == std::string_view::npos ? std::string_view() : text.substr(begin, end - begin + 1);
}

bool equalsIgnoringCase(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](char x, char y) { return lower(x) == lower(y); });
}

namespace {

// Takes what comes before the next comma off the list.
std::string_view takeElement(std::string_view& list) {
  const size_t comma = std::min(list.find(','), list.size());
  const std::string_view element = trimmed(list.substr(0, comma));
  list.remove_prefix(std::min(comma + 1, list.size()));
  return element;
}

std::string_view textOf(boost::beast::string_view text) { return {text.data(), text.size()}; }

// q=0, q=0.0 and so on.
bool isRefused(const boost::beast::http::param_list& parameters) {
  for (const auto& [name, value] : parameters)
    if (equalsIgnoringCase(textOf(name), "q"))
      return !value.empty() && textOf(value).find_first_not_of("0.") == std::string_view::npos;
  return false;
}

// A number that takes all of the text.
std::optional<size_t> number(std::string_view text) {
  size_t value = 0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || parsed.ec != std::errc() || parsed.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

bool namesTag(std::string_view if_none_match, std::string_view etag) {
  if (trimmed(if_none_match) == "*") return true;
  while (!if_none_match.empty()) {
    std::string_view tag = takeElement(if_none_match);
    if (tag.starts_with("W/")) tag.remove_prefix(2);
    if (tag == etag) return true;
  }
  return false;
}

bool acceptsCoding(std::string_view accept_encoding, std::string_view coding) {
  const boost::beast::http::ext_list codings({accept_encoding.data(), accept_encoding.size()});
  for (const auto& [name, parameters] : codings)
    if (equalsIgnoringCase(textOf(name), coding)) return !isRefused(parameters);
  return false;
}

RequestedRange rangeOf(std::string_view range, size_t size) {
  constexpr std::string_view kUnit = "bytes=";
  if (!range.starts_with(kUnit) || range.find(',') != std::string_view::npos) return {};
  range = trimmed(range.substr(kUnit.size()));
  const size_t dash = range.find('-');
  if (dash == std::string_view::npos) return {};
  const auto first = number(range.substr(0, dash)), last = number(range.substr(dash + 1));
  if (!first && dash > 0) return {};
  if (!last && dash + 1 < range.size()) return {};
  if (!first && !last) return {};
  if (first && last && *last < *first) return {};
  ByteRange bytes{0, size};
  if (first) {
    bytes.begin = *first;
    if (last && *last < size) bytes.end = *last + 1;
  } else {
    bytes.begin = size - std::min(*last, size);
  }
  if (bytes.begin >= bytes.end) return {RangeKind::kUnsatisfiable, {}};
  return {RangeKind::kSome, bytes};
}

}  // namespace foreland::server
