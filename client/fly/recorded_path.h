// Where the camera was in a recorded flight (client/fly/recording.h), as a path for flights to come: experiments and
// benchmarks fly it like a track. Pure but for reading the file; any thread.
#pragma once

#include <cstdint>
#include <filesystem>

#include "base/result.h"
#include "client/fly/track_path.h"

namespace foreland::client {

struct RecordedPath {
  proto::Path path;       // in the frame of the scene that was flown over; starts at time 0
  uint64_t scene_id = 0;  // of that scene
};

// Whether the file begins as recordings do; false for one that cannot be read.
bool isRecording(const std::filesystem::path& file);

// The path of a planned flight as it was planned, even if the recording ends before it does; of a steered one through
// the camera of each frame. `speed`, `from_s` and `seconds` of `options` apply. Errors name the file: it is no sound
// recording, it ends before the flight began, it is a tour of jumps, which is no path, or it ends before `from_s`; and
// options that a recording has no use for. Cost: a replay up to where the flight began.
Result<RecordedPath> readRecordedPath(const std::filesystem::path& file, const TrackOptions& options);

}  // namespace foreland::client
