// A flight in a file: what the player was told to fly, and all that came in, with times (docs/FLY.md). A replay of it
// gives the same frames, so it serves for bug reports and as input of measurements. Whoever reads one may have it from
// anybody: any bytes end in a flight that can be replayed or in an Error.
//
// A recording is written as the flight goes, so a program that is killed leaves one that ends early. One owner.
#pragma once

#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <string_view>

#include "base/result.h"
#include "client/fly/flight_digest.h"
#include "client/fly/player.h"

namespace foreland::client {

inline constexpr std::string_view kRecordingLine = "foreland flight 1\n";  // the first of every recording

class RecordingWriter {
 public:
  // Begins the file anew. An Error if it cannot be written.
  static Result<RecordingWriter> create(const std::filesystem::path& path, const PlayerOptions& options);

  // Appends what is new in the log since the last call; it reaches the system at once. After an Error there is no use
  // in calling it again.
  Status append(std::span<const FlightLog::Entry> entries);
  // Ends the recording with what the flight showed, for comparing replays with.
  Status finish(const FlightDigest::Value& shown);

 private:
  RecordingWriter(std::filesystem::path path, std::ofstream file) : path_(std::move(path)), file_(std::move(file)) {}
  void put(uint8_t what, Time time, ByteSpan bytes);
  Status flush();

  std::filesystem::path path_;
  std::ofstream file_;
  size_t appended_ = 0;
};

struct Recording {
  FlightLog log;
  std::optional<FlightDigest::Value> shown;  // absent if the recording ends early
};

// An Error names the file and what is wrong with it; one that ends early is none.
Result<Recording> readRecording(const std::filesystem::path& path);

}  // namespace foreland::client
