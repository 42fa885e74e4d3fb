#include "sim/link_trace.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <limits>

#include "base/printable.h"

namespace foreland::sim {

namespace {

Error malformed(const std::string& name, size_t line, const std::string& what) {
  return {ErrorCode::kMalformed, name + ":" + std::to_string(line) + ": " + what};
}

std::string_view trimmed(std::string_view line) {
  const auto isBlank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!line.empty() && isBlank(line.back())) line.remove_suffix(1);
  while (!line.empty() && isBlank(line.front())) line.remove_prefix(1);
  return line;
}

}  // namespace

Result<LinkTrace> LinkTrace::parse(std::string_view text, const std::string& name) {
  LinkTrace trace;
  size_t number = 0;
  while (!text.empty()) {
    const size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    ++number;
    if (line.empty()) continue;
    uint32_t ms = 0;
    const auto [rest, error] = std::from_chars(line.data(), line.data() + line.size(), ms);
    if (error != std::errc() || rest != line.data() + line.size())
      return malformed(name, number, "'" + printable(line.substr(0, 40)) + "' is not a time in whole milliseconds");
    if (!trace.at_ms_.empty() && ms < trace.at_ms_.back())
      return malformed(name, number, "the time " + std::to_string(ms) + " ms is before the one above it");
    trace.at_ms_.push_back(ms);
  }
  if (trace.at_ms_.empty()) return malformed(name, number, "the trace has no line");
  if (trace.at_ms_.back() == 0) return malformed(name, number, "the trace ends at 0 ms, so its rate is not known");
  return trace;
}

Result<LinkTrace> LinkTrace::read(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{ErrorCode::kNotFound, "cannot open the trace '" + path.string() + "'"};
  std::string text{std::istreambuf_iterator<char>(file), {}};
  if (!file.eof() && !file) return Error{ErrorCode::kIo, "cannot read the trace '" + path.string() + "'"};
  if (text.size() > kMaxFileBytes) return Error{ErrorCode::kLimit, path.string() + ": a trace has at most 64 MiB"};
  return parse(text, path.string());
}

Time LinkTrace::timeOf(uint64_t opportunity) const {
  const uint64_t round = opportunity / at_ms_.size(), line = opportunity % at_ms_.size();
  return Time{static_cast<int64_t>(round * at_ms_.back() + at_ms_[line]) * 1000};
}

uint64_t LinkTrace::firstAtOrAfter(Time t) const {
  const auto ms = static_cast<uint64_t>(std::max<int64_t>(0, (t.us + 999) / 1000));
  const uint64_t period = at_ms_.back();
  // The end of a round is the beginning of the next one, and what is carried at the end comes first.
  const uint64_t round = ms > 0 ? (ms - 1) / period : 0;
  const auto line = std::lower_bound(at_ms_.begin(), at_ms_.end(), static_cast<uint32_t>(ms - round * period));
  return round * at_ms_.size() + static_cast<uint64_t>(line - at_ms_.begin());
}

Time LinkTrace::transmit(size_t bytes, Time begin, Position& at) const {
  if (const uint64_t first = firstAtOrAfter(begin); first > at.next) at = {first, kPacketBytes};
  while (bytes > at.bytes_left) {
    bytes -= at.bytes_left;
    at = {at.next + 1, kPacketBytes};
  }
  at.bytes_left -= bytes;
  const Time end = std::max(begin, timeOf(at.next));
  if (at.bytes_left == 0) at = {at.next + 1, kPacketBytes};
  return end;
}

double LinkTrace::bytesPerSecond() const {
  return 1e3 * static_cast<double>(kPacketBytes * at_ms_.size()) / static_cast<double>(at_ms_.back());
}

}  // namespace foreland::sim
