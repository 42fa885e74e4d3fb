// The command line of `foreland fly`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "apps/fly/afterwards.h"
#include "apps/report/report.h"
#include "base/result.h"
#include "client/fly/net/web_socket_client.h"
#include "client/fly/player.h"

namespace foreland::apps {

struct FlyOptions {
  std::string url;
  client::WebSocketClient::Options connection;
  std::optional<std::filesystem::path> track;
  std::optional<std::string> tour;
  std::optional<double> seconds;
  client::TrackOptions track_options;
  std::string strategy = "predict";
  std::string blend = "keyframe";
  std::optional<std::string> predictor;
  std::string occlusion = "auto";
  bool relief = false, imagery = false;
  double tau_px = 1;
  std::string keyframe_ms = "200";
  double memory_mib = proto::kDefaultMemoryBytes / 1048576.0;
  uint32_t max_triangles = 0, max_kbit_per_s = 0;  // budgets; 0 for none
  std::string viewport = "1920x1080";
  double fov_deg = 60;
  double exaggeration = 1;
  AfterwardsOptions afterwards;
  std::filesystem::path record;  // empty: nothing is recorded
  std::optional<std::string> scene_from, scene_speed;
  size_t viewers = 1;
  apps::ReportFormat format = apps::ReportFormat::kText;
};

// The options, or the exit code with which the program is to end at once: 0 after --help, 2 after a mistake, about
// which a message was printed.
struct ParsedFlyOptions {
  FlyOptions options;
  std::optional<int> exit_code;
};
ParsedFlyOptions parseFlyOptions(int argc, const char* const* argv);

// Checks every option and reads the track. Errors name the option and the values it may have.
Result<client::PlayerOptions> playerOptions(const FlyOptions& options);

}  // namespace foreland::apps
