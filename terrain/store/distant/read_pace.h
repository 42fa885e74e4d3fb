// How long the next read of a store may be, and whether it may begin: so that what is under way comes within about a
// second, and the chunk that somebody comes to need most waits no longer than that, however slow the store is. A quick
// store gets long reads, as many as there are threads.
//
// The store's rate is measured by Little's law: the mean of the bytes under way during a read, over the time that it
// took. That is the rate of all reads together, whether they share a line or each has one of its own. No clock; one
// owner, or under its lock.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/time.h"

namespace foreland::terrain {

class ReadPace {
 public:
  static constexpr size_t kMostChunks = 16;                  // of a read
  static constexpr uint64_t kMostBytes = uint64_t{1} << 20;  // likewise, but for a single chunk
  static constexpr double kUnderWay_s = 1.5;                 // what is under way, at the measured rate
  static constexpr uint64_t kReads = 8;                      // among which it is divided where that makes long reads
  static constexpr uint64_t kLeastChunksUnderWay = 2;        // or the line would be idle from answer to request

  explicit ReadPace(uint64_t chunk_bytes);

  // Of the next read; 0 if it has to wait until another one ends. The most before anything was measured.
  size_t chunks() const;
  // Of all reads together; 0 before anything was measured.
  double bytesPerSecond() const { return seconds_per_byte_ > 0 ? 1 / seconds_per_byte_ : 0; }

  struct Read {
    uint64_t bytes = 0;
    Time begun{};
    double byte_seconds = 0;  // of all reads, until it began
  };
  Read begin(uint64_t bytes, Time now);
  // `has_come`: all of its bytes, or it says nothing of the rate.
  void end(const Read& read, bool has_come, Time now);

 private:
  void advance(Time now);

  const uint64_t chunk_bytes_;
  uint64_t under_way_ = 0;
  double byte_seconds_ = 0;  // the integral of under_way_
  Time now_{};
  double seconds_per_byte_ = 0;
};

}  // namespace foreland::terrain
