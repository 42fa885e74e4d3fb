// A recorded link, in the format of mahimahi (Netravali et al., USENIX ATC 2015; manual of mm-link): each line is a
// time in whole milliseconds at which the link can carry 1500 more bytes; a time that is repeated carries as many times
// more. After the last line the trace begins again. What could be carried while nothing waits is lost. Immutable; any
// thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/time.h"

namespace foreland::sim {

class LinkTrace {
 public:
  static constexpr size_t kPacketBytes = 1500, kMaxFileBytes = 64u << 20;

  // Where a link is in its trace: the next time that can carry something, counted over all repetitions, and what is
  // left of it.
  struct Position {
    uint64_t next = 0;
    size_t bytes_left = kPacketBytes;
  };

  // Errors name the file, the line and what is wrong with it: no number, a time before the one above it, no line at
  // all, or a trace that takes no time.
  static Result<LinkTrace> parse(std::string_view text, const std::string& name);
  static Result<LinkTrace> read(const std::filesystem::path& path);

  // When the last of `bytes` is carried, of a message that is ready at `begin`. O(log lines + bytes).
  Time transmit(size_t bytes, Time begin, Position& at) const;
  // In the mean.
  double bytesPerSecond() const;

 private:
  Time timeOf(uint64_t opportunity) const;
  uint64_t firstAtOrAfter(Time t) const;

  std::vector<uint32_t> at_ms_;  // ascending, not empty; the last is the period, and is not 0
};

}  // namespace foreland::sim
