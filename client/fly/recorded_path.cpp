#include "client/fly/recorded_path.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "client/fly/recording.h"

namespace foreland::client {

namespace {

// The part of a path that is flown, from time 0: as many poses a second of the path as it has.
proto::Path partOf(const proto::Path& path, const TrackOptions& options) {
  constexpr Duration kMinStep = Duration::milliseconds(1), kMaxStep = Duration::milliseconds(60'000);
  const Duration step = Duration::seconds(path.step.toSeconds() / options.speed);
  proto::Path part{.start = {}, .step = std::clamp(step, kMinStep, kMaxStep), .poses = {}};
  const Time from = path.start + Duration::seconds(options.from_s);
  const double rest_s = (path.end() - from).toSeconds() / options.speed,
               flown_s = std::min(rest_s, options.seconds.value_or(rest_s));
  const double steps = std::floor(flown_s / part.step.toSeconds() + 1e-9);
  for (size_t i = 0; i <= std::max<size_t>(1, static_cast<size_t>(steps)) && i < proto::Path::kMaxPoses; ++i)
    part.poses.push_back(
        path.at(from + Duration::seconds(static_cast<double>(i) * part.step.toSeconds() * options.speed)));
  return part;
}

Status checkRecorded(const TrackOptions& options) {
  const auto invalidOption = [](const char* text) { return Error{ErrorCode::kInvalidArgument, text}; };
  if (options.agl_m)
    return invalidOption("--agl: a recorded flight is flown where it was flown; use it with IGC and GPX tracks");
  if (!(options.speed >= 0.01 && options.speed <= 1000)) return invalidOption("--speed must be between 0.01 and 1000");
  if (!(options.from_s >= 0)) return invalidOption("--from must be at least 0");
  return {};
}

}  // namespace

bool isRecording(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string line(kRecordingLine.size(), '\0');
  return stream.read(line.data(), std::ssize(line)) && line == kRecordingLine;
}

Result<RecordedPath> readRecordedPath(const std::filesystem::path& file, const TrackOptions& options) {
  if (Status s = checkRecorded(options); !s.ok()) return s.error();
  const auto refuse = [&](const std::string& why) {
    return Error{ErrorCode::kInvalidArgument, file.string() + ": " + why};
  };
  const Result<Recording> recording = readRecording(file);
  if (!recording) return recording.error();
  const FlightLog& log = recording->log;
  if (!log.options.is_steered && !log.options.track && log.options.tour == "jumps")
    return refuse("the tour 'jumps' was recorded, which has no path to fly again");
  const Replayed replayed = replay(log, [](const Player& player, Time) {
    return player.phase() != Player::Phase::kStanding && player.phase() != Player::Phase::kFlying;
  });
  const auto& welcome = replayed.player.viewer().welcome();
  const proto::Path& path = replayed.player.path();
  if (!welcome || !path.validate().ok()) return refuse("it ends before the flight began");
  if (!(path.start + Duration::seconds(options.from_s) < path.end()))
    return refuse("it ends before --from; the flight takes " +
                  std::to_string(static_cast<int64_t>((path.end() - path.start).toSeconds())) + " s");
  return RecordedPath{partOf(path, options), welcome->scene_id};
}

}  // namespace foreland::client
