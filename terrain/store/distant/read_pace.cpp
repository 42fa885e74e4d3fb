#include "terrain/store/distant/read_pace.h"

#include <algorithm>

namespace foreland::terrain {

ReadPace::ReadPace(uint64_t chunk_bytes) : chunk_bytes_(chunk_bytes) {}

size_t ReadPace::chunks() const {
  const size_t most = std::clamp<size_t>(static_cast<size_t>(kMostBytes / chunk_bytes_), 1, kMostChunks);
  if (seconds_per_byte_ <= 0) return most;
  // Reads of all threads at their longest are no more than this, so that the number of bytes stays finite.
  const double all_of_them = static_cast<double>(kReads * most * chunk_bytes_);
  const auto window = static_cast<uint64_t>(std::min(kUnderWay_s / seconds_per_byte_, all_of_them)) / chunk_bytes_;
  const uint64_t under_way = (under_way_ + chunk_bytes_ - 1) / chunk_bytes_;
  const uint64_t room = std::max(window, kLeastChunksUnderWay);
  if (under_way >= room) return 0;
  return std::min(
      {most, static_cast<size_t>(std::max<uint64_t>(1, window / kReads)), static_cast<size_t>(room - under_way)});
}

ReadPace::Read ReadPace::begin(uint64_t bytes, Time now) {
  advance(now);
  under_way_ += bytes;
  return {bytes, now, byte_seconds_};
}

// Times are averaged, not rates, so that one slow read counts at once, and many quick ones are needed to forget it.
void ReadPace::end(const Read& read, bool has_come, Time now) {
  constexpr double kWeight = 0.25;
  advance(now);
  under_way_ -= read.bytes;
  const double seconds = (now - read.begun).toSeconds();
  if (!has_come || seconds <= 0) return;
  const double mean_under_way = (byte_seconds_ - read.byte_seconds) / seconds;
  const double measured = seconds / mean_under_way;
  seconds_per_byte_ = seconds_per_byte_ > 0 ? seconds_per_byte_ + kWeight * (measured - seconds_per_byte_) : measured;
}

void ReadPace::advance(Time now) {
  byte_seconds_ += static_cast<double>(under_way_) * (now - now_).toSeconds();
  now_ = now;
}

}  // namespace foreland::terrain
