// The command line of `foreland render`.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/viewshed/viewshed_options.h"
#include "base/result.h"
#include "client/fly/track_path.h"
#include "proto/section/epochs.h"
#include "proto/space/pose.h"

namespace foreland::apps {

enum class Drawn : uint8_t { kFull, kSection };           // the scene at full resolution, or what a client would draw
enum class Errors : uint8_t { kNone, kMeasured };         // of the section against the full resolution
enum class Progress : uint8_t { kOnTerminals, kAlways };  // where it is shown

struct RenderOptions {
  std::filesystem::path scene;
  std::vector<std::filesystem::path> outputs;
  std::optional<std::string> pose;
  std::optional<std::filesystem::path> track;
  std::optional<std::string> tour;
  double every_s = 1;
  std::optional<double> seconds;
  client::TrackOptions track_options;
  std::optional<proto::SceneClock> scene_clock;  // with the pictures' time in the flight as its own
  Drawn drawn = Drawn::kFull;
  Errors errors = Errors::kNone;
  Progress progress = Progress::kOnTerminals;
  double tau_px = 1;
  ViewshedOptions viewshed;  // from nowhere: none is laid over the pictures
  std::string viewport = "1920x1080";
  double fov_deg = 60;
  proto::Lens lens;  // of the two above
};

// The options, checked as far as they can be without a file; or the exit code with which the program is to end at once
// (0 after --help, 2 for a mistake, already told).
struct ParsedRenderOptions {
  RenderOptions options;
  std::optional<int> exit_code;
};
ParsedRenderOptions parseRenderOptions(int argc, const char* const* argv);

// A picture's file in a sequence: %d, or %04d and the like, in its name becomes the number. Without it, the name
// itself.
std::filesystem::path numbered(const std::filesystem::path& pattern, size_t number);

}  // namespace foreland::apps
